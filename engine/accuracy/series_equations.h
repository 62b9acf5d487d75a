#pragma once

#include <functional>

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

using Solution = std::function<MotionState(double)>;

/// One closed form in two precisions. The distance of the two solutions is the error of the coarser
/// one; the error of the finer one is smaller by the ratio of their roundings.
struct ComparedForm {
  Solution fine, coarse;
  struct Precision {
    /// Bound of the error of the fine solution divided by the distance, with some bits to spare.
    double finer;
    double unit;  ///< rounding error of an angle of 1
  } precision;
  double rate;  ///< ‖Ω‖_F or ‖Q̇‖_F, 1/time
  double work;  ///< work of a state in both precisions
  std::string description;
  double start = 0;  ///< distance of Q from its manifold, on which the closed form is the motion
};

inline constexpr ComparedForm::Precision in_quadruple = {0x1p-40,
                                                         0x1p-111};  // 113 bits against 64 bits
inline constexpr ComparedForm::Precision in_extended = {0x1p-6,
                                                        0x1p-62};  // 64 bits against 53 bits

/// Units of work of a state of Euler's top in both precisions, as callgrind counts them. A closed
/// form of at most so much work is constructed whatever the budget, to report its price.
inline constexpr double top_in_extended = 1.6e4;
/// Returns the units of work that the eigenvectors of a skew n × n matrix take in both precisions,
/// and their products with `rows` × n matrices.
double eigenvectors_work(Eigen::Index n, Eigen::Index rows);

template <class Scalar, class Derived>
auto rounded(const Eigen::MatrixBase<Derived>& A) {
  return A.template cast<Scalar>().eval();
}

/// The precision in which the states of a closed form in Scalar are put into the scene's variables.
template <class Scalar>
using Shown = std::conditional_t<std::is_same_v<Scalar, Quad>, Quad, long double>;

template <class Scalar>
ReportedForm<Shown<Scalar>> reported_form(const SeriesStart<Quad>& start) {
  const ReportedForm<Quad>& as = start.reported;
  return {as.right, as.complex, rounded<Shown<Scalar>>(as.diagonal),
          rounded<Shown<Scalar>>(as.axes)};
}

/// Returns the reference of a closed form; null where its error estimate does not hold at `time`.
std::unique_ptr<Reference> closed_form_reference(ComparedForm form, const ReferenceNeed& need,
                                                 double time);

}  // namespace stiefel
