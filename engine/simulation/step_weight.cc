#include "engine/simulation/step_weight.h"

#include <algorithm>
#include <string_view>

#include "engine/simulation/simulation.h"

namespace stiefel {
namespace {

struct Weight {
  std::string_view system, method;
  int order;
  std::string_view arithmetic;
  double at_3, a, b, c;
};

constexpr Weight weights[] = {
#include "engine/simulation/step_weights.inc"
};

/// Instructions a nanosecond, for what is not in the table yet.
constexpr double instructions = 5;

/// Null if it is not there.
const Weight* find(std::string_view system, std::string_view method, int order,
                   std::string_view arithmetic) {
  const auto found = std::ranges::find_if(weights, [&](const Weight& w) {
    return w.system == system && w.method == method && w.order == order &&
           w.arithmetic == arithmetic;
  });
  return found == std::end(weights) ? nullptr : found;
}

}  // namespace

bool is_weighed(std::string_view system, std::string_view method, int order,
                std::string_view arithmetic) {
  return find(system, method, order, arithmetic) != nullptr;
}

double step_weight(const Scene& scene) {
  const bool plain = scene.arithmetic() == Arithmetic::plain;
  const Weight* found =
      find(scene.system(), scene.method(), scene.order(), plain ? "plain" : "compensated");
  if (found == nullptr)
    return instructions * make_simulation(scene)->step_cost() / scene.substeps();
  const auto& given = scene.description();
  const bool pair = !given.inertia_u.empty();
  const Eigen::MatrixXd& frame = scene.block(scene.system() == "ellipsoid" ? "q" : "Q");
  const double N = pair ? static_cast<double>(given.inertia_v.size()) : scene.dimension();
  const double n = pair               ? static_cast<double>(given.inertia_u.size())
                   : frame.size() > 0 ? static_cast<double>(frame.rows())
                                      : N;
  if (n == 3 && N == 3 && found->at_3 > 0) return found->at_3;
  return found->a + found->b * n * N + found->c * (n * n * N + n * n * n);
}

}  // namespace stiefel
