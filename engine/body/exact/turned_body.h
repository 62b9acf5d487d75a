#pragma once

#include <optional>
#include <variant>

#include "engine/body/exact/euler_top.h"
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

  TwoValuedBody(const Vector<Scalar>& lambda, const Point& start)
      : start_(start),
        x_(start),
        M_(start.bottomRows(start.cols())),
        E_(M_),
        product_(M_),
        by_M_(M_ / sum(lambda)),
        by_D_(D(lambda, M_)) {}

  const Point& at(Scalar t) {
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

 private:
  /// Returns α + β.
  static Scalar sum(const Vector<Scalar>& lambda) { return lambda.minCoeff() + lambda.maxCoeff(); }

  static Matrix<Scalar> D(const Vector<Scalar>& lambda, const Matrix<Scalar>& M) {
    Matrix<Scalar> D = Matrix<Scalar>::Zero(M.rows(), M.cols());
    for (Eigen::Index j = 0; j < D.cols(); ++j)
      for (Eigen::Index i = 0; i < D.rows(); ++i)
        if (i != j && lambda(i) == lambda(j))
          D(i, j) = M(i, j) * (sum(lambda) - 2 * lambda(i)) / (2 * lambda(i) * sum(lambda));
    return D;
  }

  Point start_, x_;
  Matrix<Scalar> M_, E_, product_;
  SkewFlow<Scalar> by_M_, by_D_;
};

// Compiled once, in body_references.cc.
extern template class TwoValuedBody<double>;
extern template class TwoValuedBody<long double>;

/// The free rigid body in variables that its rotation multiplies, in closed form: a state is a
/// stack of N × N blocks, x(t) = x(0)R(t), where Q(t) = Q(0)R(t) follows from Λ and M(0) alone.
class TurnedBody {
 public:
  using Dense = Matrix<long double>;

  /// Whether there is a closed form: N = 3, or Λ of at most two values.
  static bool has(const Eigen::VectorXd& lambda) {
    return lambda.size() == 3 || TwoValuedBody<long double>::has(lambda);
  }

  TurnedBody(const Vector<long double>& lambda, const Dense& M, Dense start)
      : motion_(motion(lambda, M)), start_(std::move(start)), x_(start_) {}

  const Dense& at(long double t) {
    if (const auto* top = std::get_if<Top>(&motion_))
      x_.noalias() = start_ * Dense(rotation_matrix<long double>(top->at(t).head<4>()));
    else
      x_.noalias() =
          start_ * std::get<TwoValuedBody<long double>>(motion_).at(t).topRows(x_.cols());
    return x_;
  }

 private:
  using Top = EulerTop<long double>;
  using Motion = std::variant<Top, TwoValuedBody<long double>>;

  /// Returns the motion from Q = I.
  static Motion motion(const Vector<long double>& lambda, const Dense& M) {
    const Eigen::Index N = lambda.size();
    if (N == 3) {
      Top::Point start;
      start << 1, 0, 0, 0, vee(M);
      return Top(PrincipalMoments3<long double>(lambda), start);
    }
    Dense start(2 * N, N);
    start << Dense::Identity(N, N), M;
    return TwoValuedBody<long double>(lambda, start);
  }

  Motion motion_;
  Dense start_, x_;
};

}  // namespace stiefel
