#include "stiefel/simulation.h"

#include <cmath>
#include <numbers>

#include "engine/methods/adaptive.h"
#include "engine/motion/ensemble.h"
#include "engine/motion/system_entry.h"
#include "engine/numbers/to_text.h"
#include "stiefel/catalogue.h"

namespace stiefel {
namespace {

/// Returns |ω| of a scene whose frames are rotations of three dimensions and whose steps are times;
/// else nullopt.
std::optional<double> angular_speed(const Scene& scene, double rate) {
  const Rate of = system_entry(scene.system())->rate;
  if (scene.dimension() != 3 || of == Rate::other) return std::nullopt;
  if (of == Rate::angular_speed) return rate;
  return scene.Q().rows() == 3 ? std::optional(rate / std::numbers::sqrt2) : std::nullopt;
}

/// Returns "; the largest |h| that has one here is 0.512", rounded down, because a longer step has
/// none; "" where none was found.
std::string largest(const RunStatus& status) {
  if (!status.largest_step) return "";
  const double unit = std::pow(10, std::floor(std::log10(*status.largest_step)) - 3);
  return "; the largest |h| that has one here is " +
         to_text(std::floor(*status.largest_step / unit) * unit, 4);
}

/// Describes the edge of the domain in degrees: "the step of 0.5 turns the body by 143° and has
/// ...".
std::string left_domain(const RunStatus& status, const Scene& scene, double speed) {
  const double h = std::abs(scene.step()) / scene.substeps();
  const auto degrees = [&](double time) {
    const double angle = time * speed * 180 / std::numbers::pi;
    return (angle < 100 ? to_text(angle, 3) : to_text(std::round(angle), 6)) + "°";
  };
  std::string sentence = scene.substeps() > 1 ? "the substep of " : "the step of ";
  sentence += to_text(h, 4) + " turns the body by " + degrees(h) +
              " and has no solution on the principal branch" + largest(status);
  if (status.largest_step) sentence += ", which turns it by " + degrees(*status.largest_step);
  return sentence;
}

std::string member_of(const RunStatus& status) {
  return status.member ? "member " + std::to_string(*status.member) + ": " : "";
}

bool chooses_own_steps(const MethodInfo& method) { return method.default_tolerance > 0; }

/// Describes the end of a method that chooses its own substeps.
std::string no_substeps_left(const Scene& scene) {
  return "the step-size control of " + scene.method() + " did not reach the end of the step of " +
         to_text(scene.step() / scene.substeps(), 4) + ": it needs more than " +
         std::to_string(Adaptive::most_substeps) +
         " substeps, or shorter ones than 1e-12 of it; a shorter step or a larger "
         "method.tolerance needs fewer";
}

/// Names a method that can go on where the scene's own cannot: the closed form where there is one,
/// else the adaptive method. For a discrete system these are methods of its continuous counterpart.
std::string neighbour(const Scene& scene) {
  const SystemEntry& entry = *system_entry(scene.system());
  const SystemInfo* system =
      entry.info.discrete ? catalogue().system(entry.continuous) : &entry.info;
  if (system == nullptr) return "";
  const std::string of = system == &entry.info ? "" : " of the system " + std::string(system->name);
  for (const bool closed_form : {true, false})
    for (const MethodOnSystem& on : system->methods) {
      const MethodInfo& method = *catalogue().method(on.method);
      if ((closed_form ? method.orders.empty() : chooses_own_steps(method)) &&
          scene.method() != on.method && (!on.takes || on.takes(scene.inertia())))
        return "; the method " + std::string(on.method) + of +
               (closed_form ? " takes every step" : " chooses its own steps");
    }
  return "";
}

}  // namespace

std::string to_sentence(const RunStatus& status) {
  const auto of_one = [&] -> std::string {
    switch (status.outcome) {
      case Outcome::reached:
        return "";
      case Outcome::left_domain:
        return "the step has no solution on the principal branch" + largest(status);
      case Outcome::solver_stalled:
        return "the solver of the implicit step did not converge";
      case Outcome::not_finite:
        return "the next state is not finite";
      case Outcome::cancelled:
        return "the run was cancelled";
    }
    return "";
  };
  return member_of(status) + of_one();
}

std::string to_sentence(const RunStatus& status, const Scene& scene, double rate) {
  const MethodInfo* method = catalogue().method(scene.method());
  const auto speed = angular_speed(scene, rate);
  const bool stopped = !status.reached() && status.outcome != Outcome::cancelled;
  std::string sentence = to_sentence(status);
  if (status.outcome == Outcome::solver_stalled && method && chooses_own_steps(*method))
    sentence = member_of(status) + no_substeps_left(scene);
  if (status.outcome == Outcome::left_domain && speed && std::isfinite(*speed))
    sentence = member_of(status) + left_domain(status, scene, *speed);
  return sentence + (stopped ? neighbour(scene) : "");
}

double rate_at(const RunStatus& status, const Simulation& last) {
  const auto* ensemble = dynamic_cast<const Ensemble*>(&last);
  return ensemble && status.member ? ensemble->rate(static_cast<std::size_t>(*status.member))
                                   : last.rate();
}

}  // namespace stiefel
