#include "engine/linalg/matrix_equations/decompositions.h"
#include "engine/linalg/matrix_equations/eigenvectors.h"
#include "engine/linalg/matrix_equations/lyapunov_equation.h"
#include "engine/linalg/matrix_equations/symmetric_lyapunov.h"

namespace stiefel {

template class Lyapunov<long double>;
template class SymmetricLyapunov<long double>;
template class SymmetricLyapunov<Quad>;

}  // namespace stiefel

template class Eigen::PartialPivLU<stiefel::Matrix<long double>>;
