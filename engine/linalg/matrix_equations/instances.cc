#include "engine/linalg/iteration/fixed_point.h"
#include "engine/linalg/matrix_equations/constraint_riccati.h"
#include "engine/linalg/matrix_equations/decompositions.h"
#include "engine/linalg/matrix_equations/lyapunov_equation.h"
#include "engine/linalg/matrix_equations/symmetric_lyapunov.h"

namespace stiefel {

template class Lyapunov<double>;

template class SymmetricLyapunov<double>;

template class ConstraintRiccati<double>;

template class FixedPoint<double>;

}  // namespace stiefel

template class Eigen::PartialPivLU<stiefel::Matrix<double>>;
template class Eigen::LLT<stiefel::Matrix<double>>;
template Eigen::Index Eigen::internal::llt_inplace<double, Eigen::Lower>::blocked(
    stiefel::Matrix<double>&);
template class Eigen::HouseholderQR<stiefel::Matrix<double>>;
template class Eigen::ColPivHouseholderQR<stiefel::Matrix<double>>;
