#include "tests/support/linalg/quadruple.h"

#include "engine/dense/decompositions_of.h"
#include "engine/frame/frame_pass_on.h"

namespace stiefel {

template class Exponential<Quad>;
template class Lyapunov<Quad>;
template class SkewFlow<Quad>;
template Matrix<Quad> orthonormal_columns(const Matrix<Quad>&, Eigen::Index, Eigen::Index);
template SkewEigen<Quad> skew_eigen(const Matrix<Quad>&);
template Vector<long double> symmetric_eigenvalues(const Matrix<long double>&);
template long double skew_norm(const Matrix<long double>&);
template class ConstraintRiccati<Quad>;
template class RattleStiefel<Quad>;

}  // namespace stiefel
