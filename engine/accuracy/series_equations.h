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

}  // namespace stiefel
