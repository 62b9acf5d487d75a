#include "engine/rigid_body/body/angular_velocity.h"

namespace stiefel {

template class AngularVelocity<double>;

}  // namespace stiefel
