#pragma once

#include <Eigen/Dense>
#include <cstdint>

#include "engine/dense/inertia_operator.h"
#include "engine/motion/tangent_map.h"
#include "stiefel/simulation.h"
#include "stiefel/violation.h"

namespace stiefel {

/// Returns the tangents of a system; null if it has none.
const Tangents* tangents_of(std::string_view system);
/// Returns the tangent of a method for the scene's system and dimension; null if it has none.
const MethodTangent* tangent_of(const Scene& scene, std::string_view method);
/// Returns the refusal of a scene that has no tangent, an ensemble or one by its method, which
/// names the methods that have one; empty if it has one.
Violations without_tangent(const Scene& scene);

/// Returns an orthonormal basis of the range of A, without directions shorter than 1e-7 of the
/// longest column.
Eigen::MatrixXd orthonormal_range(Eigen::MatrixXd A);

/// Return tangent vectors with their numbers column by column from numbers row by row, and the
/// reverse.
Eigen::MatrixXd by_columns(const Eigen::MatrixXd& V, Eigen::Index rows, Eigen::Index cols);
inline Eigen::MatrixXd by_rows(const Eigen::MatrixXd& V, Eigen::Index rows, Eigen::Index cols) {
  return by_columns(V, cols, rows);  // a transposed matrix has the other order
}

/// Returns the blocks of a state in the caller's axes, stacked by rows.
Eigen::MatrixXd blocks_of(const Simulation& motion);

/// The coordinates of tangent vectors at the states of a scene (linearization.h). States and
/// vectors are blocks stacked by rows, in the caller's axes; a vector is a column, its numbers
/// column by column.
class TangentChart {
 public:
  /// Takes a scene that has tangents, and one of its states.
  TangentChart(const Scene& scene, const Dense& x);

  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return cols_; }
  Eigen::Index size() const { return rows_ * cols_; }
  const TangentSpace& space() const { return space_; }
  /// Whether the coordinates are (η, δM).
  bool is_body() const { return !space_.tangent; }

  /// Returns the basis at x, rows·cols × dimension.
  Dense basis(const Dense& x) const;
  /// Returns that basis, and behind it one of the other directions in which the states of all Λ
  /// together lie: derivatives by Λ have parts along them.
  Dense basis_of_every_inertia(const Dense& x) const;
  /// Returns the coordinates of vectors at x, in the second basis if `of_every_inertia`.
  Dense coordinates(const Dense& x, const Dense& V, bool of_every_inertia) const;
  /// Returns the tangent part of a vector at x.
  Dense tangent(const Dense& x, const Dense& G) const;
  /// Returns the tangent parts of all unit matrices at x.
  Dense tangents_of_units(const Dense& x) const { return tangents(x, space_.tangent); }

 private:
  /// Returns tangent(x, E) of every unit matrix E.
  Dense tangents(const Dense& x,
                 const std::function<Dense(const Dense&, const Dense&)>& tangent) const;
  /// The number of coordinates of a skew matrix.
  Eigen::Index half() const { return cols_ * (cols_ - 1) / 2; }
  bool has_frame() const { return rows_ > cols_; }

  TangentSpace space_;
  Eigen::Index rows_, cols_;
};

/// The tangent vectors by which growth is measured, in the caller's axes: a vector is a column, the
/// state's blocks stacked by rows, its numbers column by column. Its length is that of the weighted
/// numbers: each block is divided by its norm at the first state over the root of its rows.
class GrowthVectors {
 public:
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

/// The numbers of the states of a scene that has tangents, and at most how many directions their
/// tangent spaces have.
struct StateExtent {
  double size, dimension;
  bool is_body;  ///< its coordinates are (η, δM)
};
StateExtent extent_of(const Scene& scene);

}  // namespace stiefel
