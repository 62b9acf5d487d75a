#include "server/convert/fork.h"

#include "engine/scene/near_name.h"
#include "server/convert/conversion.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "stiefel/catalogue.h"

namespace stiefel::server {
namespace {

/// Returns the place of violations in what a fork does not change: the session that it comes from.
Place inherited() { return Place::made_of("from_session_id"); }

/// Returns the scene converted to another system.
OrStatus<Scene> in_system(const std::string& system, const Scene& scene) {
  if (catalogue().system(system) == nullptr)
    return std::unexpected(errors::invalid(
        "system", system,
        "must be a system" + did_you_mean(system, catalogue().systems, &SystemInfo::name)));
  ConversionTarget target{system};
  target.scene = inherited();
  target.to = "system";
  auto converted = convert(scene, target);
  if (!converted) return std::unexpected(refused(converted.error()));
  return *std::move(converted->scene);
}

/// Sets the method and step of a description from the request.
OrStatus<Place> change(const v1::ForkSessionRequest& request, SceneDescription& description) {
  Place place = inherited();
  if (request.has_method()) {
    const Place inside = Place::inside("method");
    auto method = from_proto(request.method(), inside);
    if (!method) return std::unexpected(errors::invalid(method.error()));
    description.method = *std::move(method);
    place.with("method", "method");
  }
  if (request.has_step()) {
    description.step = request.step();
    place.with("step", "step");
  }
  return place;
}

}  // namespace

OrStatus<ResolvedScene> forked(const Session& from, const Cursor& cursor,
                               const v1::ForkSessionRequest& request) {
  auto scene = scene_at(from.scene(), cursor.simulation(), Place::made_of("from_step"));
  if (!scene) return std::unexpected(errors::invalid(scene.error()));
  if (request.has_system() && request.system() != from.scene().system()) {
    auto converted = in_system(request.system(), *scene);
    if (!converted) return std::unexpected(converted.error());
    scene = *std::move(converted);
  }
  if (request.has_method() || request.has_step()) {
    SceneDescription description = scene->description();
    const auto place = change(request, description);
    if (!place) return std::unexpected(place.error());
    scene = Scene::resolve(std::move(description), Scene::frame_tolerance, *place);
    if (!scene) return std::unexpected(errors::invalid(scene.error()));
  }
  Difference changes = difference(from.scene().description(), scene->description());
  return ResolvedScene{*std::move(scene), {std::move(changes), std::nullopt}, inherited()};
}

}  // namespace stiefel::server
