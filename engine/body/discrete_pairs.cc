#include "engine/body/discrete_pairs.h"

#include <algorithm>
#include <limits>

#include "engine/body/j_d/j_d_n.h"
#include "engine/body/principal_branch.h"
#include "engine/dense/decompositions.h"

namespace stiefel {

template double principal_cosine(const Matrix<double>& Q, const Matrix<double>& P);
template MatrixWithin<double> root_of_one_plus_square(const Matrix<double>& A);

MatrixWithin<double> Sigma_L_inverse(const Vector<double>& lambda, const Matrix<double>& Q,
                                     const Matrix<double>& M, double h) {
  auto U = J_D_inverse(lambda, -h * M);
  if (U) *U = (Q * *U).eval();
  return U;
}

double margin_E_L(const Vector<double>& lambda, const Matrix<double>& U) {
  const Matrix<double> W = U * lambda.asDiagonal();
  const Eigen::VectorXcd w = spectrum(W);
  double margin = std::numeric_limits<double>::infinity();
  for (Eigen::Index j = 0; j < w.size(); ++j)
    for (Eigen::Index i = 0; i < j; ++i) margin = std::min(margin, std::abs(w(i) + w(j)));
  return margin;
}

MatrixWithin<double> J_D_inverse(const Vector<double>& lambda, const Matrix<double>& K) {
  PrincipalBranch<JDInverseN> branch(lambda, 1.0);
  auto memory = branch.memory();
  Accumulator<Matrix<double>> x(K, Arithmetic::compensated);
  if (const RunStatus status = branch.solve(x, memory); !status.reached()) {
    const double norm = skew_norm(K);
    return std::unexpected(
        OutsideDomain{"J_D(SO(N))", norm, status.largest_step.value_or(0) * norm});
  }
  branch.inverse().transport(x, memory);
  return Matrix<double>(Matrix<double>::Identity(K.rows(), K.cols()) +
                        branch.inverse().U_minus_I());
}

}  // namespace stiefel
