#include "engine/rigid_body/body/taylor_rigid_body.h"

namespace stiefel {

template class TaylorRigidBody<long double>;
template class TaylorMotion<TaylorRigidBody<long double>>;
template class TaylorRigidBody<Quad>;
template class TaylorMotion<TaylorRigidBody<Quad>>;

}  // namespace stiefel
