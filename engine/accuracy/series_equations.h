#pragma once

#include <memory>

#include "engine/accuracy/reference.h"
#include "engine/catalogue/series_start.h"

namespace stiefel {

/// Returns Taylor series as reference.
using MakeTaylorSeries = std::unique_ptr<Reference>(const SeriesStart<long double>& start,
                                                    const ReferenceNeed& need);
/// Returns a closed form as reference, whose states take at most `allowed` units of work each; null
/// where there is none whose error estimate holds at `time`.
using MakeClosedForm = std::unique_ptr<Reference>(const SeriesStart<Quad>& start,
                                                  const ReferenceNeed& need, double time,
                                                  double allowed);

/// The references for all motions that obey the same equations.
struct SeriesEquations {
  MakeTaylorSeries* taylor;
  MakeClosedForm* closed_form = nullptr;  ///< null for equations without one
};

MakeTaylorSeries taylor_rigid_body, taylor_parametric_rigid_body, taylor_stiefel,
    taylor_double_bracket;
MakeClosedForm closed_form_of_body, closed_form_of_geodesic;

}  // namespace stiefel
