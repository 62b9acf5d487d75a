#include "engine/motion/step_weight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "engine/motion/system_entry.h"

namespace stiefel {
namespace {

/// The instructions of a step of a method on a system at h‖Ω‖ = 0.1, with an n x N frame.
struct StepPrice {
  std::string_view systems;     ///< or packed_SYSTEM, with a pack of bodies in place of one
  std::string_view method;      ///< empty for a discrete system
  std::string_view arithmetic;  ///< empty for both
  bool composed;  ///< whether the numbers are of order 2, of which higher ones consist
  std::array<double, 2> small;  ///< of a body with N = 3 and N = 4; 0 where `large` holds
  std::array<double, 2> row;    ///< n = 1: a + bN; 0 where `large` holds
  /// a + bn² + cnN + dn²N + en³; of a closed form min(2n, N)³ takes the place of n³.
  std::array<double, 5> large;
  /// The factors at h‖Ω‖ = 0.01, 0.03 and 0.3 of a method that iterates, for N >= from and n > 1.
  struct {
    double from = 0;
    std::array<double, 3> factors = {1, 1, 1};
  } rates = {};
};

constexpr StepPrice prices[] = {
#include "engine/motion/step_prices.inc"
};
/// Estimates the step of a method that is not in the list.
constexpr StepPrice estimate = {"", "", "", false, {}, {}, {5000, 0, 120, 15, 15}};

/// Returns the system whose step a scene's is: a view has that of the body.
std::string_view moved_system(const Scene& scene) {
  const SystemEntry& system = *system_entry(scene.system());
  return system.priced_as.empty() ? system.info.name : system.priced_as;
}

/// Finds the price of a scene's step, or with the prefix "packed_" that of a pack.
const StepPrice& find(const Scene& scene, const std::string& prefix = "",
                      const std::string& suffix = "") {
  const std::string name = " " + prefix + std::string(moved_system(scene)) + suffix + " ";
  const bool plain = scene.arithmetic() == Arithmetic::plain;
  const auto* found = std::ranges::find_if(prices, [&](const StepPrice& one) {
    return one.method == scene.method() && (" " + std::string(one.systems) + " ").contains(name) &&
           (one.arithmetic.empty() || (one.arithmetic == "plain") == plain);
  });
  return found == std::end(prices) ? estimate : *found;
}

/// Returns the number of steps of order 2 whose work a step of this order takes, composed of 5, 9
/// or 17 of them.
double stages(int order) {
  constexpr double warm = 0.93;  // the start of a stage is close to its solution
  return order <= 2 ? 1 : warm * (order == 4 ? 5 : order == 6 ? 9 : 17);
}

double instructions(const StepPrice& price, const FrameSize& size, bool closed_form) {
  const auto [n, N] = size;
  if (n == N && (N == 3 || N == 4))
    if (const double small = price.small[N == 3 ? 0 : 1]; small > 0) return small;
  if (n == 1 && price.row[0] > 0) return price.row[0] + price.row[1] * N;
  const double k = closed_form ? std::min(2 * n, N) : n;
  const auto& c = price.large;
  return c[0] + c[1] * n * n + c[2] * n * N + c[3] * n * n * N + c[4] * k * k * k;
}

double instructions(const StepPrice& price, const Scene& scene) {
  const bool closed_form = scene.order() == 0 && !scene.method().empty();
  return (price.composed ? stages(scene.order()) : 1) *
         instructions(price, frame_size(scene), closed_form);
}

}  // namespace

FrameSize frame_size(const Scene& scene) {
  const SystemEntry& system = *system_entry(scene.system());
  if (system.size) return system.size(scene);
  const Eigen::MatrixXd& frame = scene.block(std::string(system.info.blocks.front().name));
  const double N = scene.dimension();
  return {frame.size() > 0 ? static_cast<double>(frame.rows()) : N, N};
}

bool is_weighed(const Scene& scene) { return &find(scene) != &estimate; }

std::optional<std::string> estimate_warning(const Scene& scene) {
  if (scene.method().empty() || is_weighed(scene)) return std::nullopt;
  return "the work of a step of " + scene.method() + " on " + scene.system() +
         " is estimated: the list of prices has no entry for it";
}

double step_weight(const Scene& scene) { return instructions(find(scene), scene); }

bool price_depends_on_rate(const Scene& scene) {
  const auto& rates = find(scene).rates;
  return rates.from > 0 && scene.dimension() >= rates.from && frame_size(scene).n > 1;
}

double step_price(const Scene& scene, double h_omega) {
  const double weight = step_weight(scene);
  if (!price_depends_on_rate(scene) || !(h_omega > 0)) return weight;
  const auto& factors = find(scene).rates.factors;
  const std::array<double, 4> at = {0.01, 0.03, 0.1, 0.3},
                              factor = {factors[0], factors[1], 1, factors[2]};
  const auto above = std::ranges::lower_bound(at, h_omega) - at.begin();
  if (above == 0) return weight * factor.front();
  if (above == std::ssize(at)) return weight * factor.back();
  const auto k = static_cast<std::size_t>(above);
  const double share = std::log(h_omega / at[k - 1]) / std::log(at[k] / at[k - 1]);
  return weight * factor[k - 1] * std::pow(factor[k] / factor[k - 1], share);
}

std::optional<double> pack_price(const Scene& one) {
  const StepPrice& found = find(one, "packed_", one.has_frame() ? "" : "_momentum");
  if (&found == &estimate || one.dimension() > 4) return std::nullopt;
  return instructions(found, one);
}

}  // namespace stiefel
