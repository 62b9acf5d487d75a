#include "server/convert/resolve.h"

#include <optional>
#include <utility>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {

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
  auto& [made, choice] = *resolved;
  Resolution resolution{difference(given, field_digests(made.description())), std::nullopt};
  if (choice)
    resolution.choice = ChosenMethod{choice->tolerance, choice->horizon, std::move(choice->reason),
                                     choice->error, choice->verified};
  return ResolvedScene{std::move(made), std::move(resolution), place};
}

}  // namespace stiefel::server
