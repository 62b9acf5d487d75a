#pragma once

#include <Eigen/Core>
#include <optional>

#include "stiefel/connect.h"

namespace stiefel {

/// The metric tr(ΛQ̇ᵀQ̇) with Λ of the order of 1.
class PosedMetric {
 public:
  explicit PosedMetric(const Eigen::VectorXd& inertia);

  const Eigen::VectorXd& lambda() const { return lambda_; }
  /// Λ = scale · lambda, a power of 4.
  double scale() const { return scale_; }
  /// Returns √(tr(ΛVᵀV)) for a tangent vector V at Q, for n = N with negative λ_i too.
  double norm(const Eigen::MatrixXd& V) const;
  /// Returns the tangent vector at Q nearest to V in R^{nN}.
  static Eigen::MatrixXd tangent(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& V);

 private:
  Eigen::VectorXd lambda_;
  double scale_;
};

/// Returns what is wrong with Λ as a metric on V(n, N) of at most `most_degrees` dimensions.
std::optional<refusal::Invalid> metric_fault(const Eigen::VectorXd& inertia, Eigen::Index n,
                                             Eigen::Index N, Eigen::Index most_degrees);

}  // namespace stiefel
