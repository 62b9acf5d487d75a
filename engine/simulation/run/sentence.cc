#include "stiefel/simulation.h"

#include <cmath>
#include <numbers>

#include "engine/linalg/arithmetic/to_text.h"
#include "stiefel/catalogue.h"

namespace stiefel {
namespace {

/// |ω| of a scene whose frames are rotations of three dimensions and whose steps are times.
std::optional<double> angular_speed(const Scene& scene, double rate) {
  const std::string& system = scene.system();
  if (scene.dimension() != 3 || system.starts_with("parametric") || system == "discrete_stiefel")
    return std::nullopt;
  const bool frames = system.starts_with("stiefel") || system == "ellipsoid";
  if (!frames) return rate;
  // There the rate is ‖Q̇‖_F = ‖Ω‖_F = √2 |ω| if Q is 3 × 3, and else the frame is no rotation.
  if (scene.Q().rows() != 3) return std::nullopt;
  return rate / std::numbers::sqrt2;
}

/// What the domain's edge is in degrees: "the step of 0.5 turns the body by 143° and has ...".
std::string left_domain(const RunStatus& status, const Scene& scene, double speed) {
  const double h = std::abs(scene.step()) / scene.substeps();
  const auto degrees = [&](double time) {
    const double angle = time * speed * 180 / std::numbers::pi;
    return (angle < 100 ? to_text(angle, 3) : to_text(std::round(angle), 6)) + "°";
  };
  std::string sentence = scene.substeps() > 1 ? "the substep of " : "the step of ";
  sentence +=
      to_text(h, 4) + " turns the body by " + degrees(h) +
      " and has no solution on the principal branch; the largest |h| that has one here is " +
      to_text(status.largest_step.value_or(0), 4);
  if (status.largest_step) sentence += ", which turns it by " + degrees(*status.largest_step);
  return sentence;
}

/// What takes the scene where its own method does not: the closed form where there is one, else the
/// method that chooses its own steps; of a discrete body the continuous one.
std::string neighbour(const Scene& scene) {
  const bool discrete_body = scene.system() == "moser_veselov";
  const auto& methods = catalogue().system(discrete_body ? "rigid_body" : scene.system())->methods;
  const std::string of = discrete_body ? " of the system rigid_body" : "";
  for (const char* name : {"exact", "adaptive"})
    for (const auto& on : methods)
      if (on.method == name && scene.method() != name && (!on.takes || on.takes(scene.inertia())))
        return name == std::string("exact")
                   ? "; the method exact" + of + " takes every step"
                   : "; the method adaptive" + of + " chooses its own steps";
  return "";
}

}  // namespace

std::string to_sentence(const RunStatus& status) {
  if (status.member) {
    RunStatus of_one = status;
    of_one.member.reset();
    return "member " + std::to_string(*status.member) + ": " + to_sentence(of_one);
  }
  switch (status.outcome) {
    case Outcome::reached:
      return "";
    case Outcome::left_domain:
      return "the step has no solution on the principal branch; the largest |h| that has one here "
             "is " +
             to_text(status.largest_step.value_or(0), 4);
    case Outcome::solver_stalled:
      return "the solver of the implicit step did not converge";
    case Outcome::not_finite:
      return "the next state is not finite";
    case Outcome::cancelled:
      return "the run was cancelled";
  }
  return "";
}

std::string to_sentence(const RunStatus& status, const Scene& scene) {
  const bool stopped = !status.reached() && status.outcome != Outcome::cancelled;
  return to_sentence(status) + (stopped ? neighbour(scene) : "");
}

double rate_at(const RunStatus& status, const Simulation& last) {
  const auto members = last.members();
  if (!status.member || static_cast<std::size_t>(*status.member) >= members.size())
    return last.rate();
  return members[static_cast<std::size_t>(*status.member)]->rate();
}

std::string to_sentence(const RunStatus& status, const Scene& scene, double rate) {
  if (status.outcome != Outcome::left_domain) return to_sentence(status, scene);
  const auto speed = angular_speed(scene, rate);
  if (!speed || !std::isfinite(*speed)) return to_sentence(status, scene);
  const std::string member = status.member ? "member " + std::to_string(*status.member) + ": " : "";
  return member + left_domain(status, scene, *speed) + neighbour(scene);
}

}  // namespace stiefel
