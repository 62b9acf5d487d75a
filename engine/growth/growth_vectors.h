#pragma once

#include <cstdint>

#include "engine/growth/coordinates.h"

namespace stiefel {

/// The tangent vectors by which growth is measured, in the caller's axes: a vector is a column, the
/// state's blocks stacked by rows, its numbers column by column. Its length is that of the weighted
/// numbers: each block is divided by its norm at the first state over the root of its rows.
class GrowthVectors {
 public:
  using Dense = Eigen::MatrixXd;

  /// The most vectors of states whose tangent space is too large to be counted.
  static constexpr std::int64_t most_of_large = 64;

  /// Takes a scene that has tangents, and its first state.
  GrowthVectors(const Scene& scene, const Simulation& start);

  Eigen::Index size() const { return weights_.size(); }
  /// The dimension of the tangent space at x; 0 where the state is too large for it.
  std::int64_t dimension(const Dense& x) const;

  const Eigen::VectorXd& weights() const { return weights_; }
  void set_weights(const Eigen::VectorXd& weights) { weights_ = weights; }

  /// Returns k random orthonormal vectors at x.
  Dense random(const Dense& x, Eigen::Index k, std::uint64_t seed) const;
  /// Takes the tangent parts of V at x, and V = V′R to V′, R upper triangular with r_ii ≥ 0.
  Dense orthonormalise(const Dense& x, Dense& V) const;

  Dense by_rows(const Dense& V) const { return stiefel::by_rows(V, chart_.rows(), chart_.cols()); }
  Dense by_columns(const Dense& V) const {
    return stiefel::by_columns(V, chart_.rows(), chart_.cols());
  }

 private:
  TangentChart chart_;
  Eigen::VectorXd weights_;
};

}  // namespace stiefel
