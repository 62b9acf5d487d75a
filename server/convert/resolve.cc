#include "server/convert/resolve.h"

#include <optional>
#include <utility>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {
namespace {

/// Moves the tolerance and the choice's reason out of a description that has the chosen method.
ChosenMethod take_choice(SceneDescription& resolved) {
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
  auto description = from_proto(scene, place);
  if (!description) return std::unexpected(errors::invalid(description.error()));
  // Digests take the place of a second copy of the arrays.
  const FieldDigests given = field_digests(*description);
  auto resolved = resolve_choosing(*std::move(description), Scene::frame_tolerance, place);
  if (!resolved) return std::unexpected(errors::invalid(resolved.error()));
  std::optional<ChosenMethod> choice;
  if (!resolved->description().choice.empty()) {
    SceneDescription chosen = resolved->description();
    choice = take_choice(chosen);
    resolved = Scene::resolve(std::move(chosen), Scene::frame_tolerance, place);
    if (!resolved) return std::unexpected(errors::invalid(resolved.error()));
  }
  Difference changes = difference(given, field_digests(resolved->description()));
  return ResolvedScene{*std::move(resolved), {std::move(changes), std::move(choice)}, place};
}

}  // namespace stiefel::server
