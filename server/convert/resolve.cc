#include "server/convert/resolve.h"

#include <algorithm>
#include <utility>

#include "engine/scene/near_name.h"
#include "server/convert/answers.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "stiefel/catalogue.h"

namespace stiefel::server {
namespace {

/// Returns the place of violations in what a fork does not change: the session that it comes from.
Place inherited() { return Place::made_of("from_session_id"); }

/// Returns a violation of a conversion at its place in a fork.
Violation in_fork(Violation one) {
  constexpr std::string_view scene = "scene.";
  if (one.field == "to") one.field = "system";
  if (!one.field.starts_with(scene)) return one;
  one.field.erase(0, scene.size());
  return inherited().of(std::move(one));
}

/// Returns the scene converted to another system.
Scene in_system(const std::string& system, const Scene& scene) {
  if (catalogue().system(system) == nullptr)
    throw errors::invalid(
        "system", system,
        "must be a system" + did_you_mean(system, catalogue().systems, &SystemInfo::name));
  auto converted = convert(scene, {system});
  if (converted) return *std::move(converted->scene);
  if (auto* violations = std::get_if<Violations>(&converted.error()))
    for (Violation& one : *violations) one = in_fork(std::move(one));
  else if (std::string& field = std::get<OutsideDomain>(converted.error()).field; true)
    field = in_fork({field, "", ""}).field;
  throw refused(converted.error());
}

/// Returns the scene with the method and step of the request.
Scene changed(const v1::ForkSessionRequest& request, SceneDescription description) {
  Place place = inherited();
  if (request.has_method()) {
    const Place inside = Place::inside("method");
    description.method = from_proto(request.method(), inside);
    place.with("method", "method");
  }
  if (request.has_step()) {
    description.step = request.step();
    place.with("step", "step");
  }
  return value_of(Scene::resolve(std::move(description), Scene::drift_tolerance), place);
}

/// Whether a description would be a scene with the method that is to be chosen for it.
bool lacks_only_a_method(const SceneDescription& description) {
  const auto scene = Scene::resolve(description);
  return !scene && std::ranges::all_of(scene.error(), [](const Violation& violation) {
    return violation.reason == "METHOD_NOT_CHOSEN";
  });
}

/// Whether resolving the scene chooses a method, which takes about a second.
bool wants_choice(const v1::Scene& scene) { return scene.has_tolerance() && !scene.has_method(); }

}  // namespace

ResolvedScene read_scene(bool present, const v1::Scene& scene, const char* field,
                         const std::function<void(std::uint64_t bytes)>& hold) {
  if (!present) throw errors::invalid(field, "absent", "must be given");
  const auto place = Place::inside(field);
  SceneDescription description = from_proto(scene, place);
  if (!scene.has_method() && !scene.has_tolerance()) hold(recommendation_workspace(description));
  if (wants_choice(scene) && lacks_only_a_method(description)) hold(choice_workspace(description));
  auto [made, choice] = value_of(resolve_choosing(std::move(description)), place);
  return {std::move(made), std::move(choice), place};
}

ResolvedScene forked(const Session& from, const Cursor& cursor,
                     const v1::ForkSessionRequest& request) {
  Scene scene = value_of(scene_at(from.scene(), cursor.simulation()), Place::made_of("from_step"));
  if (request.has_system() && request.system() != from.scene().system())
    scene = in_system(request.system(), scene);
  if (request.has_method() || request.has_step()) scene = changed(request, scene.description());
  return {std::move(scene), std::nullopt, inherited()};
}

std::string to_bytes(const Scene& scene) {
  v1::Scene message;
  to_proto(scene.description(), &message);
  return message.SerializeAsString();
}

std::expected<Scene, std::string> scene_of(const std::string& bytes) {
  v1::Scene message;
  if (!message.ParseFromString(bytes)) return std::unexpected("its row holds no scene");
  try {
    return value_of(Scene::resolve(from_proto(message)));
  } catch (const StatusError& error) {
    return std::unexpected(error.status.error_message());
  }
}

std::optional<Choice> choice_of(const std::string& bytes) {
  v1::Choice choice;
  if (bytes.empty() || !choice.ParseFromString(bytes)) return std::nullopt;
  return Choice{from_proto(choice.method()), choice.tolerance(), choice.horizon(), choice.error(),
                choice.reason()};
}

}  // namespace stiefel::server
