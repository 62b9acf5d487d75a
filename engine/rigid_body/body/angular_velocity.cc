#include "engine/rigid_body/body/angular_velocity.h"

namespace stiefel {

template class AngularVelocity<double>;
template class AngularVelocity<long double>;
template class AngularVelocity<Quad>;

}  // namespace stiefel
