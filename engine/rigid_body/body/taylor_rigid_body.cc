#include "engine/rigid_body/body/taylor_rigid_body.h"

namespace stiefel {

template class TaylorRigidBody<long double>;
template class TaylorMotion<TaylorRigidBody<long double>>;

}  // namespace stiefel
