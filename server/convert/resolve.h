#pragma once

#include <cstdint>
#include <expected>
#include <functional>
#include <optional>
#include <string>

#include "server/convert/place.h"
#include "server/sessions/cursor.h"
#include "stiefel/scene.h"
#include "stiefel/tradeoff.h"
#include "stiefel/v1/scene.pb.h"
#include "stiefel/v1/session.pb.h"

namespace stiefel::server {

/// A resolved scene.
struct ResolvedScene {
  Scene scene;
  std::optional<Choice> choice;  ///< set where the method was chosen for a tolerance
  Place place;  ///< of the scene in the request, for violations that are found later
};

/// Returns the resolved scene of a request; a tolerance is replaced by the method chosen for it.
/// Calls `hold`, which may throw, with the bytes that it takes to find a method for a scene without
/// one. Throws INVALID_ARGUMENT with paths below `field`.
ResolvedScene read_scene(bool present, const v1::Scene& scene, const char* field,
                         const std::function<void(std::uint64_t bytes)>& hold);

/// Returns the resolved scene that starts at the cursor's state, with the changes of the request.
/// Throws INVALID_ARGUMENT.
ResolvedScene forked(const Session& from, const Cursor& cursor,
                     const v1::ForkSessionRequest& request);

/// Returns a resolved scene as the bytes of a stiefel.v1.Scene, which keeps every bit.
std::string to_bytes(const Scene& scene);

/// Returns the scene of such bytes, or why this build cannot resolve it.
std::expected<Scene, std::string> scene_of(const std::string& bytes);

/// Returns the choice of the bytes of a stiefel.v1.Choice; nothing if there are none.
std::optional<Choice> choice_of(const std::string& bytes);

}  // namespace stiefel::server
