#include "engine/parametric/taylor_parametric_rigid_body.h"

namespace stiefel {

template class TaylorParametricRigidBody<long double>;
template class TaylorMotion<TaylorParametricRigidBody<long double>>;
template class TaylorParametricRigidBody<Quad>;
template class TaylorMotion<TaylorParametricRigidBody<Quad>>;

}  // namespace stiefel
