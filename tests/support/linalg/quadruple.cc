#include "tests/support/linalg/quadruple.h"

#include "engine/frames/passes/frame_pass_on.h"
#include "engine/linalg/lie/exponential_of.h"
#include "engine/linalg/matrix_equations/decompositions_of.h"
#include "engine/linalg/matrix_equations/lyapunov_equation_of.h"

namespace stiefel {

template class Exponential<Quad>;
template class Lyapunov<Quad>;
template Matrix<Quad> orthonormal_columns(const Matrix<Quad>&, Eigen::Index, Eigen::Index);
template SkewEigen<Quad> skew_eigen(const Matrix<Quad>&);
template Vector<long double> symmetric_eigenvalues(const Matrix<long double>&);
template class ConstraintRiccati<Quad>;
template class RattleStiefel<Quad>;

}  // namespace stiefel
