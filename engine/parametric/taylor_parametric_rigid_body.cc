#include "engine/parametric/taylor_parametric_rigid_body.h"

namespace stiefel {

template class TaylorParametricRigidBody<long double>;
template class TaylorMotion<TaylorParametricRigidBody<long double>>;

}  // namespace stiefel
