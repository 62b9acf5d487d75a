#pragma once

namespace stiefel {

/// The equations that the motion of a system obeys in the variables of its start (series_start.h).
/// engine/accuracy/series_equations.h has the references for them.
struct SeriesEquations;

namespace series_equations {
extern const SeriesEquations rigid_body, parametric_rigid_body, stiefel, double_bracket;
}  // namespace series_equations

}  // namespace stiefel
