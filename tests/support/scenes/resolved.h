#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "stiefel/scene.h"

namespace stiefel::testing {

/// Returns the scene of a description. Throws what is wrong with it where it is refused.
inline Scene resolved(SceneDescription description) {
  auto scene = Scene::resolve(std::move(description));
  if (scene) return *std::move(scene);
  std::string why;
  for (const auto& v : scene.error()) why += v.field + " = " + v.value + ": " + v.rule + "; ";
  throw std::runtime_error(why);
}

}  // namespace stiefel::testing
