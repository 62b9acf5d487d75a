#include "tests/support/toys/toys.h"

#include <cmath>

#include "engine/motion/make_simulation.h"
#include "engine/motion/system_entry.h"
#include "tests/support/toys/heun.h"
#include "tests/support/toys/lie_midpoint.h"

namespace stiefel {

// For the library's methods CMake writes these.
MethodEntry heun_method() { return method_entry_of<Heun>(); }
MethodEntry lie_midpoint_method() { return method_entry_of<LieMidpoint>(); }

SystemEntry brockett_entry();

namespace testing {

RowMatrix two_by_two(double s) {
  RowMatrix H(2, 2);
  H << std::tanh(s), 1 / std::cosh(s), 1 / std::cosh(s), -std::tanh(s);
  return H;
}

SceneDescription toy_scene(const std::string& method, double s, double step) {
  SceneDescription d;
  d.system = "brockett";
  if (!method.empty()) d.method = MethodDescription{method, {}, {}, "", {}};
  d.inertia = {2, 1};
  d.initial["H"] = two_by_two(s);
  d.step = step;
  return d;
}

}  // namespace testing
}  // namespace stiefel
