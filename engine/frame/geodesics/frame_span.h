#pragma once

#include <Eigen/Core>

namespace stiefel {

/// The products Q_0Q_0ᵀ, Q_TQ_Tᵀ and Q_TQ_0ᵀ of two n × N frames. Not finite where a frame is not.
struct FrameProducts {
  Eigen::MatrixXd of_Q_0, of_Q_T, mixed;
};
FrameProducts frame_products(const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& Q_T);

/// The span of two n × N frames, n < N, with the orthonormal rows [Q_0; K], n + p in all, p =
/// min(n, N − n). A matrix X of n + p rows stands for the n × N block Xᵀ[Q_0; K]. Where the frames
/// are far enough apart, K is not computed: it is L⁻¹(Q_T − CQ_0), C = Q_TQ_0ᵀ and LLᵀ the products
/// of these rows. Refers to the arguments of the constructor.
class FrameSpan {
 public:
  FrameSpan(const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& Q_T, const FrameProducts& products);

  /// Returns the X of Q_T.
  const Eigen::MatrixXd& target() const { return target_; }
  /// Returns the block of X.
  Eigen::MatrixXd lifted(const Eigen::MatrixXd& X) const;

 private:
  struct Squares {
    double least, ratio;
  };
  /// Finds L of K = L⁻¹Z from the products of the rows of Z; `whole` becomes whole · L. Returns the
  /// least square of a length that a row of Z has beside the rows before it, and its ratio to the
  /// largest; 0 where the rows are dependent.
  Squares factor(const Eigen::MatrixXd& products, Eigen::MatrixXd& whole);
  bool is_implied(const FrameProducts& products);
  /// Computes K in two passes; the second one first removes what rounding left of Q_0. Returns
  /// false where its rows are nearly dependent.
  bool is_orthonormalised();

  const Eigen::MatrixXd &Q_0_, &Q_T_, &C_;
  Eigen::Index n_, p_;
  Eigen::MatrixXd K_, to_K_, target_;  ///< K = to_K_ · K_, or of Q_T − CQ_0 where K_ is empty
};

}  // namespace stiefel
