#include "engine/dense/angular_velocity.h"
#include "engine/dense/skew_spectrum.h"

namespace stiefel {

template class AngularVelocity<double>;
template class AngularVelocity<long double>;
template class AngularVelocity<Quad>;

template double skew_norm(const Matrix<double>& M);

template Vector<double> casimirs(const Matrix<double>& M);

}  // namespace stiefel
