#include "engine/body/discrete_pairs.h"

#include <algorithm>
#include <limits>

#include "engine/body/j_d/cayley_n.h"
#include "engine/dense/continuation.h"
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
  CayleyN<double> cayley(lambda, 1);
  cayley.start(K);
  if (!cayley.newton(K)) {
    cayley.C().setZero();
    Matrix<double> last = cayley.C();
    const double reached = continuation(1, [&](double t) {
      cayley.C() = last;
      const bool found = cayley.newton(t * K);
      if (found) last = cayley.C();
      return found;
    });
    const double norm = skew_norm(K);
    if (!(reached >= 1)) return std::unexpected(OutsideDomain{"J_D(SO(N))", norm, reached * norm});
  }
  const Matrix<double> I = Matrix<double>::Identity(K.rows(), K.cols());
  return Matrix<double>(Lu<double>(I - cayley.C()).solve(I + cayley.C()));
}

}  // namespace stiefel
