#include <algorithm>
#include <cmath>

#include "engine/dense/so_3.h"
#include "engine/motion/method_entry.h"
#include "engine/motion/resolve.h"
#include "engine/motion/system_entry.h"
#include "engine/scene/near_name.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {
namespace {

/// Checks `order`, which must be one that the method has, and fills it in unless the method has
/// none.
void check_order(SceneDraft& draft, const MethodInfo& info) {
  auto& order = draft.given().method->order;
  if (info.orders.empty()) {
    if (order)
      draft.refuse("method.order", std::to_string(*order),
                   "must be absent: " + std::string(info.name) + " has no order");
    return;
  }
  if (std::ranges::count(info.orders, order.value_or(info.default_order)) == 0)
    draft.refuse("method.order", std::to_string(*order),
                 "for " + std::string(info.name) + " must be one of " +
                     listed(info.orders, [](int o) { return std::to_string(o); }));
  order = order.value_or(info.default_order);
}

void check_tolerance(SceneDraft& draft, const MethodInfo& info) {
  auto& tolerance = draft.given().method->tolerance;
  if (!info.default_tolerance) {
    if (tolerance)
      draft.refuse("method.tolerance", to_text(*tolerance),
                   std::string(info.name) + " takes steps of a fixed size and no tolerance");
    return;
  }
  if (!(tolerance.value_or(info.default_tolerance) >= 1e-15 && tolerance.value_or(1e-6) <= 1))
    draft.refuse("method.tolerance", to_text(*tolerance), "must be 1e-15 to 1");
  tolerance = tolerance.value_or(info.default_tolerance);
}

/// Returns the rule for scenes in single precision.
std::string float_is_for() {
  std::string rule = "must be double: float is for N = 3 of";
  for (const SystemInfo& system : catalogue().systems) {
    std::vector<std::string_view> methods;
    for (const MethodOnSystem& on : system.methods)
      if (on.in_float) methods.push_back(on.method);
    if (!methods.empty())
      rule += " " + std::string(system.name) + " by " + listed(methods, std::identity{});
  }
  return rule;
}

void check_scalar(SceneDraft& draft, const SystemInfo& system) {
  auto& method = *draft.given().method;
  if (method.scalar.empty()) method.scalar = "double";
  if (method.scalar == "double") return;
  const auto rule = [&](const std::string& text) {
    draft.refuse("method.scalar", '"' + method.scalar + '"', text);
  };
  if (method.scalar != "float") return rule("must be double or float");
  for (const MethodOnSystem& on : system.methods)
    if (on.method == method.name && on.in_float) return;
  rule(float_is_for());
}

/// Returns whether dM/dt, or dS/dt, of size ‖M‖‖Ω‖, or Ω² is next to denormal although a step turns
/// the frame. A method that adds up this rate would then see no motion. M is the momentum of a
/// body, or the S of a frame.
bool rate_underflows(const Eigen::Ref<const Eigen::MatrixXd>& M, bool of_body,
                     const Eigen::VectorXd& lambda, double step) {
  constexpr double least_rate = 1e-302, least_turn = 1e-18;
  double size = 0, speed = 0;  // the largest elements of M and Ω
  for (Eigen::Index j = 0; j < M.cols(); ++j)
    for (Eigen::Index i = 0; i < M.rows(); ++i) {
      const double inertia = of_body ? lambda(i) + lambda(j) : lambda(j), m = std::abs(M(i, j));
      size = std::max(size, m);
      if (!of_body || i != j) speed = std::max(speed, m / inertia);
    }
  return std::min(size, speed) * speed < least_rate && std::abs(step) * speed > least_turn;
}

bool rate_underflows(const Scene& scene, const SystemInfo& system) {
  return std::ranges::any_of(system.blocks, [&](const BlockInfo& info) {
    const bool of_body = info.name == "M" && info.required;
    return (of_body || info.name == "S") && rate_underflows(scene.block(std::string(info.name)),
                                                            of_body, scene.inertia(), scene.step());
  });
}

/// Returns the name of the first method of a system that takes every Λ; "none" if there is none.
std::string takes_every_inertia(const SystemInfo& system) {
  for (const auto& on : system.methods)
    if (!on.takes) return std::string(on.method);
  return "none";
}

}  // namespace

bool accepts_body(const MethodEntry* method, const Body3& body, double step) {
  return method == nullptr || !method->by_field ||
         !rate_underflows(hat(body.m), true, body.lambda, step);
}

void check_method(SceneDraft& draft, const SystemInfo& system) {
  auto& method = *draft.given().method;
  const MethodInfo* info = nullptr;
  for (const auto& on : system.methods)
    if (on.method == method.name) info = catalogue().method(on.method);
  if (info == nullptr)
    return draft.refuse("method.name", '"' + method.name + '"',
                        "must be one of " + listed(system.methods, &MethodOnSystem::method) +
                            did_you_mean(method.name, system.methods, &MethodOnSystem::method));
  check_order(draft, *info);
  check_tolerance(draft, *info);
  const int substeps = method.substeps.value_or(1);
  if (substeps < 1 || substeps > 1'000'000)
    draft.refuse("method.substeps", std::to_string(substeps), "must be 1 to 1000000");
  method.substeps = substeps;
  if (method.arithmetic.empty()) method.arithmetic = "compensated";
  if (method.arithmetic != "compensated" && method.arithmetic != "plain")
    draft.refuse("method.arithmetic", '"' + method.arithmetic + '"',
                 "must be compensated or plain");
  check_scalar(draft, system);
}

void check_method_accepts_scene(SceneDraft& draft, const SystemInfo& system) {
  const auto& method = draft.given().method;
  if (!method) return;
  const Eigen::VectorXd& lambda = draft.scene().inertia();
  for (const auto& on : system.methods)
    if (on.method == method->name && lambda.size() > 0 && on.takes && !on.takes(lambda))
      draft.refuse("method.name",
                   '"' + method->name + "\" with N = " + std::to_string(lambda.size()),
                   "is only for " + std::string(on.where) + "; " + takes_every_inertia(system) +
                       " takes every Lambda");
  if (method->scalar == "float" && lambda.size() > 0 && lambda.size() != 3)
    draft.refuse("method.scalar", "\"float\" with N = " + std::to_string(lambda.size()),
                 float_is_for());
  const SystemEntry& entry = *system_entry(system.name);
  const MethodEntry* moves = method_entry(method->name);
  if (draft.sound() && draft.given().step && moves != nullptr && moves->by_field &&
      rate_underflows(draft.scene(), system))
    draft.refuse("method.name", '"' + method->name + '"',
                 "sums the rate of the momentum, which underflows in these units: choose other "
                 "units of mass, length and time, or " +
                     takes_every_inertia(system));
  if (!draft.sound() || entry.refusal == nullptr) return;
  const std::string rule = entry.refusal(draft.scene(), method->name);
  if (!rule.empty()) draft.refuse("method.name", '"' + method->name + '"', rule);
}

}  // namespace stiefel
