#include "server/convert/stored_scene.h"

#include <utility>

#include "server/convert/convert.h"

namespace stiefel::server {
namespace {

std::unexpected<std::string> because(const Violations& violations) {
  const Violation& first = violations.front();
  return std::unexpected(first.field + ": " + first.value + ": " + first.rule);
}

}  // namespace

std::string to_bytes(const Scene& scene) {
  v1::Scene message;
  to_proto(scene.description(), &message);
  return message.SerializeAsString();
}

std::expected<Scene, std::string> scene_of(const std::string& bytes) {
  v1::Scene message;
  if (!message.ParseFromString(bytes)) return std::unexpected("its row holds no scene");
  auto description = from_proto(message);
  if (!description) return because(description.error().violations);
  auto scene = Scene::resolve(*std::move(description));
  if (!scene) return because(scene.error());
  return *std::move(scene);
}

}  // namespace stiefel::server
