#include "engine/accuracy/series_equations.h"

namespace stiefel::series_equations {

constinit const SeriesEquations rigid_body = {taylor_rigid_body, closed_form_of_body};
constinit const SeriesEquations parametric_rigid_body = {taylor_parametric_rigid_body};
constinit const SeriesEquations stiefel = {taylor_stiefel, closed_form_of_geodesic};
constinit const SeriesEquations double_bracket = {taylor_double_bracket};

}  // namespace stiefel::series_equations
