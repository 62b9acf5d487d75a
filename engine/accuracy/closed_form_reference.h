#pragma once

#include <functional>

#include "engine/accuracy/series_equations.h"

namespace stiefel {

using Solution = std::function<MotionState(double)>;

/// One closed form in two precisions. The distance of the two solutions is the error of the coarser
/// one; the error of the finer one is smaller by the ratio of their roundings.
struct ClosedForm {
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

inline constexpr ClosedForm::Precision in_quadruple = {0x1p-40,
                                                       0x1p-111};        // 113 bits against 64 bits
inline constexpr ClosedForm::Precision in_extended = {0x1p-6, 0x1p-62};  // 64 bits against 53 bits

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
std::unique_ptr<Reference> closed_form_reference(ClosedForm form, const ReferenceNeed& need,
                                                 double time);

}  // namespace stiefel
