#include "tests/support/toys/toys.h"

#include <cmath>

namespace stiefel::testing {

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

}  // namespace stiefel::testing
