#include "stiefel/scene.h"

#include <algorithm>
#include <iterator>

#include "engine/linalg/arithmetic/to_text.h"
#include "engine/methods/exact.h"
#include "engine/simulation/catalogue/methods/motion_rates.h"
#include "engine/simulation/catalogue/methods/step_weight.h"
#include "engine/simulation/catalogue/system_entry.h"

namespace stiefel {
namespace {

/// Part of the largest moment by which a triangle inequality of the moments may fail, because the
/// moments or their tensor were rounded.
constexpr double rounding = 16 * 0x1p-53;

std::string numbered(const char* name, Eigen::Index i) { return name + std::to_string(i + 1); }

std::string of_moments(const Eigen::Vector3d& I) {
  Eigen::Index k;
  const double largest = I.maxCoeff(&k);
  const Eigen::Index i = k == 0 ? 1 : 0, j = k == 2 ? 1 : 2;
  const double sum = I(i) + I(j);
  if (!(sum < largest * (1 - rounding))) return "";
  return numbered("I", i) + " + " + numbered("I", j) + " = " + to_text(sum) + " < " +
         numbered("I", k) + " = " + to_text(largest) + ": no rigid body has these moments";
}

std::string of_inertia(const Eigen::VectorXd& lambda) {
  if (lambda.size() == 0) return "";
  Eigen::Index k;
  const double least = lambda.minCoeff(&k);
  if (!(least < -rounding * lambda.maxCoeff())) return "";
  const std::string name = numbered("lambda", k) + " = " + to_text(least) + " < 0";
  if (lambda.size() != 3) return name + ": no rigid body has this second moment of mass";
  const std::string moments =
      of_moments({lambda(1) + lambda(2), lambda(2) + lambda(0), lambda(0) + lambda(1)});
  return moments.empty() ? "" : name + ", " + moments;
}

std::string of_body(const Scene& scene) {
  return scene.axes() ? of_moments(scene.axes()->moments) : of_inertia(scene.inertia());
}

/// Returns a warning where a body in three dimensions is so near a separatrix that rounding decides
/// its motion.
std::string of_separatrix(const Scene& scene) {
  const SystemEntry& entry = *system_entry(scene.system());
  if (!entry.packed || entry.info.discrete || scene.dimension() != 3) return "";
  const double parameter = separatrix_parameter(scene);
  if (!(parameter < next_to_separatrix)) return "";
  const std::string where =
      "the motion is next to a separatrix: 1 - k^2 = " + short_text(parameter) +
      " of its elliptic functions";
  return where + (scene.method() == Exact::traits.name
                      ? "; the ensemble has the method exact, which keeps the motion"
                      : "; rounding grows by its inverse, and only exact keeps the motion");
}

/// Returns the warning of a scene, or of the first member that has one.
std::vector<std::string> of_each(const Scene& scene, std::string (*of)(const Scene&)) {
  if (scene.members().empty()) {
    const std::string text = of(scene);
    return text.empty() ? std::vector<std::string>() : std::vector{text};
  }
  std::string first;
  std::size_t count = 0;
  for (std::size_t b = 0; b < scene.members().size(); ++b) {
    const std::string text = of(scene.members()[b]);
    if (text.empty()) continue;
    if (++count == 1) first = "member " + std::to_string(b) + ": " + text;
  }
  if (count == 0) return {};
  if (count > 1) first += " (" + std::to_string(count) + " members have a warning like this)";
  return {first};
}

}  // namespace

std::vector<std::string> warnings(const Scene& scene) {
  std::vector<std::string> all = of_each(scene, of_body);
  if (!scene.members().empty() || scene.method() != Exact::traits.name)
    std::ranges::move(of_each(scene, of_separatrix), std::back_inserter(all));
  if (auto estimated = estimate_warning(scene)) all.push_back(*std::move(estimated));
  return all;
}

}  // namespace stiefel
