#pragma once

#include <algorithm>

#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/dense/orthogonal.h"

namespace stiefel {

/// The geodesic flow on V(n, N) with Λ = λI, or in a metric of β, in closed form (Edelman, Arias
/// and Smith 1998): with Y = Qᵀ, H = Q̇ᵀ = YA + KR, A = YᵀH skew and K orthonormal columns that
/// complete Y,
///
///     Y(t) = [Y K] exp(tW) [I; 0] e^{(1−2β)tA},   Ẏ(t) = [Y K] exp(tW) [A; R] e^{(1−2β)tA},
///     W = [[2βA, −Rᵀ], [R, 0]].
///
/// β = 1 is Λ = λI. Costs O(Nn² + n³). States are Q over S = λQ̇.
template <class Scalar>
class IsotropicGeodesic {
 public:
  using Point = Matrix<Scalar>;

  static bool has(const Vector<double>& lambda) { return (lambda.array() == lambda(0)).all(); }

  IsotropicGeodesic(const Vector<Scalar>& lambda, const Point& start, Scalar beta = 1)
      : IsotropicGeodesic(lambda(0), beta, start.topRows(start.rows() / 2).transpose(),
                          start.bottomRows(start.rows() / 2).transpose() / lambda(0)) {}

  const Point& at(Scalar t) {
    by_W_(t, E_);
    turned_.noalias() = YK_ * E_;
    by_A_((1 - 2 * beta_) * t, back_);
    product_.noalias() = turned_.leftCols(n_) * back_;
    x_.topRows(n_) = product_.transpose();
    AR_back_.noalias() = AR_ * back_;
    product_.noalias() = turned_ * AR_back_;
    x_.bottomRows(n_) = lambda_ * product_.transpose();
    return x_;
  }

 private:
  IsotropicGeodesic(Scalar lambda, Scalar beta, const Matrix<Scalar>& Y, const Matrix<Scalar>& H)
      : n_(Y.cols()),
        lambda_(lambda),
        beta_(beta),
        YK_(completed(Y, H)),
        AR_(YK_.transpose() * H),
        by_W_(W(n_, AR_, beta)),
        by_A_(skew_part(AR_.topRows(n_))),
        turned_(YK_),
        product_(Y),
        AR_back_(AR_),
        x_(2 * n_, Y.rows()) {}

  /// Returns [Y K], with K from the QR factors of [Y H].
  static Matrix<Scalar> completed(const Matrix<Scalar>& Y, const Matrix<Scalar>& H) {
    const Eigen::Index N = Y.rows(), n = Y.cols(), k = std::min(n, N - n);
    Matrix<Scalar> both(N, 2 * n);
    both << Y, H;
    Matrix<Scalar> YK = orthonormal_columns(both, n + k);
    YK.leftCols(n) = Y;
    return YK;
  }
  static Matrix<Scalar> W(Eigen::Index n, const Matrix<Scalar>& AR, Scalar beta) {
    const Eigen::Index k = AR.rows() - n;
    Matrix<Scalar> W = Matrix<Scalar>::Zero(n + k, n + k);
    W.topLeftCorner(n, n) = 2 * beta * skew_part(AR.topRows(n));
    W.bottomLeftCorner(k, n) = AR.bottomRows(k);
    W.topRightCorner(n, k) = -AR.bottomRows(k).transpose();
    return W;
  }

  Eigen::Index n_;
  Scalar lambda_, beta_;
  Matrix<Scalar> YK_;  ///< [Y K]
  Matrix<Scalar> AR_;  ///< [A; R]
  SkewFlow<Scalar> by_W_, by_A_;
  Matrix<Scalar> E_, turned_, product_, back_, AR_back_;
  Point x_;
};

// Compiled once, in frame_references.cc.
extern template class IsotropicGeodesic<double>;
extern template class IsotropicGeodesic<long double>;

}  // namespace stiefel
