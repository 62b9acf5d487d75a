#include "engine/representations/angular_velocity.h"

namespace stiefel {

template class AngularVelocity<double>;

}  // namespace stiefel
