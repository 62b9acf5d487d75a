#include "engine/rigid_body/body/angular_velocity.h"
#include "engine/rigid_body/body/body_invariants.h"
#include "engine/rigid_body/body/skew_norm.h"

namespace stiefel {

template class AngularVelocity<double>;
template class AngularVelocity<long double>;
template class AngularVelocity<Quad>;

template double skew_norm(const Matrix<double>& M);

template Vector<double> casimirs(const Matrix<double>& M);

}  // namespace stiefel
