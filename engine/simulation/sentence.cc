#include "engine/linalg/to_text.h"
#include "engine/simulation/catalogue.h"
#include "engine/simulation/simulation.h"

namespace stiefel {
namespace {

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

std::string to_sentence(const Ending& ending) {
  if (ending.member) {
    Ending of_one = ending;
    of_one.member.reset();
    return "member " + std::to_string(*ending.member) + ": " + to_sentence(of_one);
  }
  switch (ending.outcome) {
    case Outcome::reached:
      return "";
    case Outcome::left_domain:
      return "the step has no solution on the principal branch; the largest |h| that has one here "
             "is " +
             to_text(ending.largest_step.value_or(0), 4);
    case Outcome::solver_stalled:
      return "the solver of the implicit step did not converge";
    case Outcome::not_finite:
      return "the next state is not finite";
    case Outcome::cancelled:
      return "the run was cancelled";
  }
  return "";
}

std::string to_sentence(const Ending& ending, const Scene& scene) {
  const bool stopped = !ending.reached() && ending.outcome != Outcome::cancelled;
  return to_sentence(ending) + (stopped ? neighbour(scene) : "");
}

}  // namespace stiefel
