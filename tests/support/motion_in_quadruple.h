#pragma once

#include <functional>

#include "engine/accuracy/reference.h"

namespace stiefel::testing {

/// Returns the exact motion of a scene as a function of time in quadruple precision: Taylor series
/// with a truncation error of 1e-30, from the scene's own blocks. The times must ascend in |t|.
/// reference_test.cc compares the series with the printed equations by extrapolation. Empty for
/// equations other than those of the body, with and without parameter, the frame and the double
/// bracket, whose series stand in headers.
std::function<MotionState(double)> motion_in_quadruple(const Scene& scene);

}  // namespace stiefel::testing
