#include "engine/rigid_body/moser_veselov/discrete_pairs.h"

#include <algorithm>
#include <limits>

#include "engine/linalg/matrix_equations/spectrum.h"
#include "engine/rigid_body/moser_veselov/j_d_inverse.h"

namespace stiefel {

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

}  // namespace stiefel
