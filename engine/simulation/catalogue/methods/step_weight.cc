#include "engine/simulation/catalogue/methods/step_weight.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/simulation/catalogue/system_entry.h"

namespace stiefel {
namespace {

struct Counted {
  double n, N, instructions;
};

struct Weight {
  std::string_view system, method;
  int order;
  std::string_view arithmetic, scalar;
  std::array<Counted, 8> sizes;  ///< then zeros
};

constexpr Weight weights[] = {
#include "engine/simulation/catalogue/methods/step_weights.inc"
};

/// Instructions a nanosecond, for what is not in the table yet.
constexpr double instructions = 5;

/// Null if it is not there.
const Weight* find(std::string_view system, std::string_view method, int order,
                   std::string_view arithmetic, std::string_view scalar) {
  const auto found = std::ranges::find_if(weights, [&](const Weight& w) {
    return w.system == system && w.method == method && w.order == order &&
           w.arithmetic == arithmetic && w.scalar == scalar;
  });
  return found == std::end(weights) ? nullptr : found;
}

const Weight* find(const Scene& scene) {
  // A closed form, which has no order, is the same in both arithmetics.
  const bool plain = scene.order() > 0 && scene.arithmetic() == Arithmetic::plain;
  return find(scene.system(), scene.method(), scene.order(), plain ? "plain" : "compensated",
              scene.in_float() ? "float" : "double");
}

double f(double n, double N) { return n * n * N + n * n * n + 8 * n * N; }

double distance(const Counted& at, double n, double N) {
  return std::abs(std::log(n / at.n)) + std::abs(std::log(N / at.N));
}

}  // namespace

FrameSize frame_size(const Scene& scene) {
  const SystemInfo& system = system_entry(scene.system())->info;
  const Eigen::MatrixXd& frame = scene.block(std::string(system.blocks.front().name));
  const double N = scene.dimension();
  return {frame.size() > 0 ? static_cast<double>(frame.rows()) : N, N};
}

bool is_weighed(std::string_view system, std::string_view method, int order,
                std::string_view arithmetic, std::string_view scalar) {
  return find(system, method, order, arithmetic, scalar) != nullptr;
}

bool is_weighed(const Scene& scene) { return find(scene) != nullptr; }

double step_weight(const Scene& scene) {
  const SystemEntry& system = *system_entry(scene.system());
  const Weight* found = find(scene);
  if (found == nullptr) return instructions * system.make(scene)->step_cost() / scene.substeps();
  const auto [n, N] = system.size ? system.size(scene) : frame_size(scene);
  const Counted* nearest = &found->sizes.front();
  for (const Counted& size : found->sizes)
    if (size.n > 0 && distance(size, n, N) < distance(*nearest, n, N)) nearest = &size;
  return nearest->instructions * f(n, N) / f(nearest->n, nearest->N);
}

}  // namespace stiefel
