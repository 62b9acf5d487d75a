#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "engine/methods/exact.h"
#include "engine/motion/motion_rates.h"
#include "engine/motion/step_weight.h"
#include "engine/motion/system_entry.h"
#include "engine/numbers/to_text.h"
#include "stiefel/scene.h"

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
  if (!scene.axes()) return of_inertia(scene.inertia());
  const std::string fault = of_moments(scene.axes()->moments);
  if (fault.empty()) return fault;
  return fault + (scene.description().body->inertia_tensor.empty()
                      ? "; are all three in one unit?"
                      : "; are all six entries in one unit, and the products those of the matrix, "
                        "Ixy = -∫ xy dm?");
}

/// Returns a warning where a body in three dimensions is so near a separatrix that rounding decides
/// its motion.
std::string of_separatrix(const Scene& scene) {
  const SystemEntry& entry = *system_entry(scene.system());
  if (!entry.rates || !entry.rates->separatrix || entry.info.discrete || scene.dimension() != 3)
    return "";
  const double parameter = entry.rates->separatrix(scene);
  if (!(parameter < next_to_separatrix)) return "";
  const std::string where =
      "the motion is next to a separatrix: 1 - k^2 = " + short_text(parameter) +
      " of its elliptic functions";
  return where + (scene.method() == Exact::traits.name
                      ? "; the ensemble has the method exact, which keeps the motion"
                      : "; the rounding of methods other than exact grows by its inverse");
}

std::string of_turn(const Scene& scene) {
  if (!scene.description().body) return "";
  const std::vector<double>& omega = scene.description().body->angular_velocity;
  const double turn =
      Eigen::Vector3d(omega.data()).stableNorm() * std::abs(scene.step()) / std::numbers::pi;
  if (!(turn > 1)) return "";
  return "a step of " + to_text(scene.step()) + " s turns the body by " +
         to_text(std::round(180 * turn)) +
         " degrees: more than half a turn; angular_velocity is in rad/s";
}

using Warning = std::string (*)(const Scene&);
constexpr std::array<Warning, 3> of_one = {of_body, of_turn, of_separatrix};

/// Returns each warning about a member once, with the first member that has it and their number.
std::vector<std::string> of_members(const Members& members) {
  std::array<std::string, of_one.size()> first;
  std::array<std::size_t, of_one.size()> count{};
  for (std::size_t b = 0; b < members.size(); ++b) {
    const Scene member = members[b];
    for (std::size_t w = 0; w < of_one.size(); ++w) {
      const std::string text = of_one[w](member);
      if (!text.empty() && ++count[w] == 1) first[w] = "member " + std::to_string(b) + ": " + text;
    }
  }
  std::vector<std::string> all;
  for (std::size_t w = 0; w < of_one.size(); ++w) {
    if (count[w] > 1)
      first[w] += " (" + std::to_string(count[w]) + " members have a warning like this)";
    if (count[w] > 0) all.push_back(first[w]);
  }
  return all;
}

}  // namespace

std::vector<std::string> warnings(const Scene& scene) {
  std::vector<std::string> all = of_members(scene.members());
  if (scene.members().empty())
    for (const Warning of : of_one) {
      if (of == of_separatrix && scene.method() == Exact::traits.name) continue;
      if (std::string text = of(scene); !text.empty()) all.push_back(std::move(text));
    }
  if (auto estimated = estimate_warning(scene)) all.push_back(*std::move(estimated));
  return all;
}

}  // namespace stiefel
