#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>

#include "engine/dense/so_3.h"
#include "engine/methods/method.h"
#include "engine/motion/body_view.h"
#include "engine/motion/given_members.h"
#include "engine/motion/step_weight.h"
#include "engine/motion/system_entry.h"
#include "engine/numbers/to_text.h"
#include "stiefel/scene.h"

namespace stiefel {
namespace {

/// Part of the largest moment by which a triangle inequality of the moments may fail, because the
/// moments or their tensor were rounded.
constexpr double lambda_rounding = 16 * 0x1p-53;

std::string numbered(const char* name, Eigen::Index i) { return name + std::to_string(i + 1); }

std::string of_moments(const Eigen::Vector3d& I) {
  Eigen::Index k;
  const double largest = I.maxCoeff(&k);
  const Eigen::Index i = k == 0 ? 1 : 0, j = k == 2 ? 1 : 2;
  const double sum = I(i) + I(j);
  if (!(sum < largest * (1 - lambda_rounding))) return "";
  return numbered("I", i) + " + " + numbered("I", j) + " = " + to_text(sum) + " < " +
         numbered("I", k) + " = " + to_text(largest) + ": no rigid body has these moments";
}

std::string of_inertia(const Eigen::VectorXd& lambda) {
  if (lambda.size() == 0) return "";
  Eigen::Index k;
  const double least = lambda.minCoeff(&k);
  if (!(least < -lambda_rounding * lambda.maxCoeff())) return "";
  const std::string name = numbered("lambda", k) + " = " + to_text(least) + " < 0";
  if (lambda.size() != 3) return name + ": no rigid body has this second moment of mass";
  const std::string moments =
      of_moments({lambda(1) + lambda(2), lambda(2) + lambda(0), lambda(0) + lambda(1)});
  return moments.empty() ? "" : name + ", " + moments;
}

std::string of_moments(const PrincipalAxes& axes, const GivenBody& given) {
  const std::string fault = of_moments(axes.moments);
  if (fault.empty()) return fault;
  return fault + (given.tensor.empty()
                      ? "; are all three in one unit?"
                      : "; are all six entries in one unit, and the products those of the matrix, "
                        "Ixy = -∫ xy dm?");
}

std::string of_turn(const GivenBody& given, double step) {
  const double turn = Eigen::Vector3d(given.angular_velocity.data()).stableNorm() * std::abs(step) /
                      std::numbers::pi;
  if (!(turn > 1)) return "";
  return "a step of " + to_text(step) + " s turns the body by " + to_text(std::round(180 * turn)) +
         " degrees: more than half a turn; angular_velocity is in rad/s";
}

/// The warnings about one body or member: each is empty where there is none.
class Warnings {
 public:
  /// Takes a scene, or the first member of an ensemble.
  explicit Warnings(const Scene& scene)
      : step_(scene.step()), exact_(scene.method() == method_name::exact) {
    const SystemEntry& entry = *system_entry(scene.system());
    const bool keeps = exact_ && scene.members().empty();
    if (entry.rates && !entry.info.discrete && scene.dimension() == 3 && !keeps)
      separatrix_ = entry.rates->separatrix;
  }

  using Texts = std::array<std::string, 3>;
  Texts of(const Scene& scene) const {
    if (scene.axes()) {
      const GivenBody given(*scene.description().body);
      return of(given, *scene.axes(), scene.inertia(), vee(scene.M()));
    }
    return {of_inertia(scene.inertia()), "",
            separatrix_ ? of_separatrix(scene.inertia(), vee(body_momentum(scene))) : ""};
  }
  Texts of(const GivenBody& given, const PrincipalAxes& axes, const Eigen::Vector3d& lambda,
           const Eigen::Vector3d& m) const {
    return {of_moments(axes, given), of_turn(given, step_), of_separatrix(lambda, m)};
  }

 private:
  /// Returns a warning where a body in three dimensions is so near a separatrix that rounding
  /// decides its motion.
  std::string of_separatrix(const Eigen::Vector3d& lambda, const Eigen::Vector3d& m) const {
    if (!separatrix_) return "";
    const double parameter = separatrix_(lambda, m);
    if (!(parameter < next_to_separatrix)) return "";
    return "the motion is next to a separatrix: 1 - k^2 = " + short_text(parameter) +
           " of its elliptic functions" +
           (exact_ ? "; the ensemble has the method exact, which keeps the motion"
                   : "; the rounding of methods other than exact grows by its inverse");
  }

  double step_;
  bool exact_;
  double (*separatrix_)(const Eigen::Vector3d&, const Eigen::Vector3d&) = nullptr;
};

}  // namespace

/// Gives each warning about members once, with the first member that has it and their number.
std::vector<std::string> warnings(const Scene& scene) {
  const Members members = scene.members();
  const Warnings one(scene);
  std::optional<GivenMembers> given;
  if (!members.empty()) given.emplace(scene.description(), members.front());
  Warnings::Texts first;
  std::array<std::size_t, first.size()> count{};
  for (std::size_t b = 0; b < std::max<std::size_t>(members.size(), 1); ++b) {
    const auto body = given && given->any() ? (*given)[b] : std::nullopt;
    const Warnings::Texts texts = body ? one.of(given->given(b), *body->axes, body->lambda, body->m)
                                  : members.empty() ? one.of(scene)
                                                    : one.of(members[b]);
    for (std::size_t w = 0; w < texts.size(); ++w)
      if (!texts[w].empty() && ++count[w] == 1)
        first[w] = (members.empty() ? "" : "member " + std::to_string(b) + ": ") + texts[w];
  }
  std::vector<std::string> all;
  for (std::size_t w = 0; w < first.size(); ++w) {
    if (count[w] > 1)
      first[w] += " (" + std::to_string(count[w]) + " members have a warning like this)";
    if (count[w] > 0) all.push_back(first[w]);
  }
  if (auto estimated = estimate_warning(scene)) all.push_back(*std::move(estimated));
  return all;
}

}  // namespace stiefel
