#include "server/convert/resolve.h"

#include <utility>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {
namespace {

/// Takes the tolerance and what the method was chosen for out of a description: the method that was
/// chosen stands for them.
std::optional<ChosenMethod> take_choice(SceneDescription& resolved) {
  if (resolved.choice.empty()) return std::nullopt;
  ChosenMethod chosen{*resolved.tolerance, *resolved.horizon, std::exchange(resolved.choice, {})};
  resolved.tolerance.reset();
  return chosen;
}

}  // namespace

bool wants_choice(const v1::Scene& scene) { return scene.has_tolerance() && !scene.has_method(); }

double most_choice_work() { return Choice::most_work; }

OrStatus<ResolvedScene> read_scene(bool present, const v1::Scene& scene, const char* field) {
  if (!present) return std::unexpected(errors::invalid(field, "absent", "must be given"));
  const auto place = Place::inside(field);
  const auto given = from_proto(scene, place);
  if (!given) return std::unexpected(errors::invalid(given.error()));
  auto resolved = resolve_choosing(*given, Scene::frame_tolerance, place);
  if (!resolved) return std::unexpected(errors::invalid(resolved.error()));
  SceneDescription description = resolved->description();
  auto choice = take_choice(description);
  if (choice) {
    resolved = Scene::resolve(description, Scene::frame_tolerance, place);
    if (!resolved) return std::unexpected(errors::invalid(resolved.error()));
  }
  Difference changes = difference(*given, resolved->description());
  return ResolvedScene{*std::move(resolved), {std::move(changes), std::move(choice)}};
}

}  // namespace stiefel::server
