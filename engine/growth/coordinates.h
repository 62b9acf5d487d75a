#pragma once

#include <Eigen/Dense>

#include "engine/motion/tangent_map.h"

namespace stiefel {

inline Eigen::MatrixXd skew_part(const Eigen::MatrixXd& A) { return (A - A.transpose()) / 2; }

/// Returns an orthonormal basis of the range of A, without directions shorter than 1e-7 of the
/// longest column.
Eigen::MatrixXd orthonormal_range(Eigen::MatrixXd A);

/// Return tangent vectors with their numbers column by column from numbers row by row, and the
/// reverse.
Eigen::MatrixXd by_columns(const Eigen::MatrixXd& V, Eigen::Index rows, Eigen::Index cols);
Eigen::MatrixXd by_rows(const Eigen::MatrixXd& V, Eigen::Index rows, Eigen::Index cols);

/// The coordinates of tangent vectors at the states of a scene (linearization.h). States and
/// vectors are blocks stacked by rows; a vector is a column, its numbers column by column.
class TangentChart {
 public:
  using Dense = Eigen::MatrixXd;

  TangentChart(TangentSpace space, Eigen::Index rows, Eigen::Index cols)
      : space_(std::move(space)), rows_(rows), cols_(cols) {}

  /// Returns the basis at x, rows·cols × dimension.
  Dense basis(const Dense& x) const;
  /// Returns that basis, and behind it one of the other directions in which the states of all Λ
  /// together lie: derivatives by Λ have parts along them.
  Dense basis_of_every_inertia(const Dense& x) const;
  /// Returns the coordinates of vectors at x, in the second basis if `of_every_inertia`.
  Dense coordinates(const Dense& x, const Dense& V, bool of_every_inertia) const;
  /// Returns the tangent part of a vector at x.
  Dense tangent(const Dense& x, const Dense& G) const;

 private:
  bool is_body() const { return !space_.tangent; }
  /// Returns tangent(x, E) of every unit matrix E.
  template <class Tangent>
  Dense tangents(const Dense& x, const Tangent& tangent) const;
  /// The skew matrix with coordinate k equal to 1.
  Dense unit(Eigen::Index k) const;
  /// Writes the coordinates of a skew matrix.
  void write_skew(const Dense& A, Eigen::Ref<Eigen::VectorXd> out) const;

  TangentSpace space_;
  Eigen::Index rows_, cols_;
};

/// The numbers of the states of a scene that has tangents, and at most how many directions their
/// tangent spaces have.
struct StateExtent {
  double size, dimension;
  bool is_body;  ///< its coordinates are (η, δM)
};
StateExtent extent_of(const Scene& scene);

}  // namespace stiefel
