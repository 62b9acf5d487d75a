#pragma once

#include "engine/accuracy/reference.h"
#include "engine/motion/series_start.h"

namespace stiefel {

/// The references for all motions that obey the same equations.
struct SeriesEquations {
  /// Returns Taylor series as reference.
  std::unique_ptr<Reference> (*taylor)(const SeriesStart<long double>& start,
                                       const ReferenceNeed& need);
  /// Whether scenes with this Λ have a closed form, which is asked first, because computing the
  /// start takes products of matrices. Null for equations without one.
  bool (*has_closed_form)(const Eigen::VectorXd& lambda) = nullptr;
  /// Returns a closed form as reference, whose states take at most `allowed` units of work each;
  /// null where there is none whose error estimate holds at `time`.
  std::unique_ptr<Reference> (*closed_form)(const SeriesStart<Quad>& start,
                                            const ReferenceNeed& need, double time,
                                            double allowed) = nullptr;
};

/// Returns a block as the scene reports it: a complex block has its real and imaginary parts in
/// adjacent columns.
template <class Scalar>
Matrix<long double> in_columns(const Matrix<Scalar>& block, bool complex) {
  if (!complex) return block.template cast<long double>();
  const Eigen::Index p = block.rows() / 2;
  Matrix<long double> columns(p, 2 * block.cols());
  for (Eigen::Index j = 0; j < block.cols(); ++j) {
    columns.col(2 * j) = block.col(j).head(p).template cast<long double>();
    columns.col(2 * j + 1) = block.col(j).tail(p).template cast<long double>();
  }
  return columns;
}

/// Returns the state of a series, the frame over `momentum_rows` rows of momentum, as the scene
/// reports it.
template <class Scalar>
MotionState present(const ReportedForm<Scalar>& as, const Matrix<Scalar>& x,
                    Eigen::Index momentum_rows) {
  Matrix<Scalar> momentum = x.bottomRows(momentum_rows);
  if (as.diagonal.size() > 0) momentum.diagonal() -= as.diagonal;
  MotionState state{in_columns<Scalar>(x.topRows(x.rows() - momentum_rows), as.complex),
                    in_columns(momentum, as.complex), as.complex};
  if (as.right) {
    state.attitude.transposeInPlace();
    state.momentum *= -1;
  }
  if (as.axes.size() > 0) {
    const Matrix<long double> R = as.axes.template cast<long double>();
    if (state.attitude.size() > 0) state.attitude = (state.attitude * R.transpose()).eval();
    state.momentum = (R * state.momentum * R.transpose()).eval();
  }
  return state;
}

}  // namespace stiefel
