#pragma once

#include <optional>

#include "engine/dense/decompositions.h"

namespace stiefel {

/// The free rigid body in N dimensions whose Λ has at most two values, α on the axes of one block
/// and β on those of the other, in closed form. D = Ω − M/(α+β) is zero outside the two diagonal
/// blocks and constant, because it commutes with the blocks of M. Then
///
///     M(t) = e^{−tD} M e^{tD},   Q(t) = Q exp(tM/(α+β)) e^{tD}.
///
/// Λ = αI is the case D = 0. States are Q over M, or M alone, N columns.
template <class Scalar>
class TwoValuedBody {
 public:
  using Point = Matrix<Scalar>;

  /// Whether Λ has at most two values.
  static bool has(const Vector<double>& lambda) {
    const double alpha = lambda(0);
    std::optional<double> beta;
    for (const double l : lambda) {
      if (l == alpha) continue;
      if (beta && l != *beta) return false;
      beta = l;
    }
    return true;
  }

  TwoValuedBody(const Vector<Scalar>& lambda, const Point& start);

  const Point& at(Scalar t);

 private:
  /// Returns α + β.
  static Scalar sum(const Vector<Scalar>& lambda) { return lambda.minCoeff() + lambda.maxCoeff(); }

  static Matrix<Scalar> D(const Vector<Scalar>& lambda, const Matrix<Scalar>& M);

  Point start_, x_;
  Matrix<Scalar> M_, E_, product_;
  SkewFlow<Scalar> by_M_, by_D_;
};

template <class Scalar>
TwoValuedBody<Scalar>::TwoValuedBody(const Vector<Scalar>& lambda, const Point& start)
    : start_(start),
      x_(start),
      M_(start.bottomRows(start.cols())),
      E_(M_),
      product_(M_),
      by_M_(M_ / sum(lambda)),
      by_D_(D(lambda, M_)) {}

template <class Scalar>
auto TwoValuedBody<Scalar>::at(Scalar t) -> const Point& {
  const Eigen::Index N = M_.rows();
  if (x_.rows() > N) {
    by_M_(t, E_);
    product_.noalias() = start_.topRows(N) * E_;
  }
  by_D_(t, E_);
  if (x_.rows() > N) x_.topRows(N).noalias() = product_ * E_;
  product_.noalias() = M_ * E_;
  auto M = x_.bottomRows(N);
  M.noalias() = E_.transpose() * product_;
  product_ = (M - M.transpose()) / 2;
  M = product_;
  return x_;
}

template <class Scalar>
Matrix<Scalar> TwoValuedBody<Scalar>::D(const Vector<Scalar>& lambda, const Matrix<Scalar>& M) {
  Matrix<Scalar> D = Matrix<Scalar>::Zero(M.rows(), M.cols());
  for (Eigen::Index j = 0; j < D.cols(); ++j)
    for (Eigen::Index i = 0; i < D.rows(); ++i)
      if (i != j && lambda(i) == lambda(j))
        D(i, j) = M(i, j) * (sum(lambda) - 2 * lambda(i)) / (2 * lambda(i) * sum(lambda));
  return D;
}

// Compiled once, in body_references.cc.
extern template class TwoValuedBody<double>;
extern template class TwoValuedBody<long double>;

}  // namespace stiefel
