#pragma once

#include <functional>
#include <vector>

#include "engine/bracket/double_bracket.h"
#include "engine/dense/inertia_operator.h"
#include "engine/dense/taylor_motion.h"
#include "engine/motion/series_start.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The Taylor coefficients of the coupled double bracket, [RB] (5.7)–(5.11), of complex p × q
/// matrices Q_k and P_k:
///
///     U_k = J_U⁻¹(A_k − A_k†),   A_k = Σ_{j ≤ k} P_j Q_{k−j}†,
///     V_k = J_V⁻¹(B_k − B_k†),   B_k = Σ_{j ≤ k} P_j† Q_{k−j},
///     (k+1) Q_{k+1} = Σ_{j ≤ k} (U_j Q_{k−j} − Q_j V_{k−j}),   and the same for P.
///
/// A state is Re Q, Im Q, Re P, Im P stacked by rows, 4p × q; products are those of the real forms
/// R(Z) of complex_as_real.
template <class Scalar_>
class TaylorDoubleBracket {
 public:
  using Scalar = Scalar_;

  TaylorDoubleBracket(const Vector<Scalar>& lambda_u, const Vector<Scalar>& lambda_v, int order)
      : order_(order),
        p_(lambda_u.size()),
        q_(lambda_v.size()),
        lambda_u_(2 * p_),
        lambda_v_(2 * q_),
        Q_(static_cast<std::size_t>(order), Matrix<Scalar>(2 * p_, 2 * q_)),
        P_(Q_),
        U_(Q_.size(), Matrix<Scalar>(2 * p_, 2 * p_)),
        V_(Q_.size(), Matrix<Scalar>(2 * q_, 2 * q_)),
        A_(2 * p_, p_),
        B_(2 * q_, q_),
        real_A_(2 * p_, 2 * p_),
        real_B_(2 * q_, 2 * q_) {
    lambda_u_ << lambda_u, lambda_u;
    lambda_v_ << lambda_v, lambda_v;
  }

  int order() const { return order_; }
  /// Returns the number of lower rows of the state, those of P, whose error is measured separately.
  Eigen::Index momentum_rows() const { return 2 * p_; }
  /// Returns the operations of a whole series, 2 for a multiplication with its addition, plus a
  /// constant for each small product.
  static double operations(Eigen::Index rows, Eigen::Index q, int order) {
    const double p = static_cast<double>(rows) / 4;
    const auto columns = static_cast<double>(q);
    return order * (order + 1) * (60 + 12 * p * columns * (p + columns));
  }

  /// Computes the series at x, with coefficient k in the columns from kq on. Returns false on a
  /// stop request.
  bool expand(const Matrix<Scalar>& x, Matrix<Scalar>& series,
              const std::function<bool()>& stopped) {
    series.resize(x.rows(), (order_ + 1) * q_);
    series.leftCols(q_) = x;
    for (int k = 0; k < order_; ++k) {
      if (stopped()) return false;
      complex_as_real(series.middleCols(k * q_, q_).topRows(2 * p_), Q_[at(k)]);
      complex_as_real(series.middleCols(k * q_, q_).bottomRows(2 * p_), P_[at(k)]);
      generate(k);
      auto next = series.middleCols((k + 1) * q_, q_);
      next.setZero();
      for (int j = 0; j <= k; ++j) {
        const auto then = series.middleCols((k - j) * q_, q_);
        const auto V = V_[at(k - j)].leftCols(q_);
        stop_point(static_cast<double>(8 * p_ * q_ * (p_ + q_)));
        next.topRows(2 * p_).noalias() += U_[at(j)] * then.topRows(2 * p_);
        next.topRows(2 * p_).noalias() -= Q_[at(j)] * V;
        next.bottomRows(2 * p_).noalias() += U_[at(j)] * then.bottomRows(2 * p_);
        next.bottomRows(2 * p_).noalias() -= P_[at(j)] * V;
      }
      next /= Scalar(k + 1);
    }
    return true;
  }

 private:
  static std::size_t at(int k) { return static_cast<std::size_t>(k); }

  /// Computes U_k and V_k from the coefficients of Q and P up to k.
  void generate(int k) {
    A_.setZero();
    B_.setZero();
    for (int j = 0; j <= k; ++j) {
      stop_point(static_cast<double>(4 * p_ * q_ * (p_ + q_)));
      A_.noalias() += P_[at(j)] * Q_[at(k - j)].topRows(p_).transpose();
      B_.noalias() += P_[at(j)].transpose() * Q_[at(k - j)].leftCols(q_);
    }
    complex_as_real(A_, real_A_);
    complex_as_real(B_, real_B_);
    inverse_inertia(lambda_u_, real_A_, Scalar(1), U_[at(k)]);
    inverse_inertia(lambda_v_, real_B_, Scalar(1), V_[at(k)]);
  }

  int order_;
  Eigen::Index p_, q_;
  Vector<Scalar> lambda_u_, lambda_v_;
  std::vector<Matrix<Scalar>> Q_, P_, U_, V_;  ///< R of each coefficient
  Matrix<Scalar> A_, B_, real_A_, real_B_;
};

/// The references of these equations.
extern const SeriesEquations double_bracket_equations;

// Compiled once, in taylor_double_bracket.cc.
extern template class TaylorDoubleBracket<long double>;
extern template class TaylorMotion<TaylorDoubleBracket<long double>>;

}  // namespace stiefel
