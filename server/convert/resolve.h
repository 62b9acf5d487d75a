#pragma once

#include <grpcpp/support/status.h>

#include <expected>

#include "server/sessions/resolution.h"
#include "stiefel/v1/scene.pb.h"

namespace stiefel::server {

template <class T>
using OrStatus = std::expected<T, grpc::Status>;

/// A scene, and how it came from what the caller gave.
struct ResolvedScene {
  Scene scene;
  Resolution resolution;
};

/// The resolved scene of a request; in the place of a tolerance it has the method that was chosen
/// for it. INVALID_ARGUMENT with the paths below `field`.
OrStatus<ResolvedScene> read_scene(bool present, const v1::Scene& scene,
                                   const char* field = "scene");

/// Whether to resolve it is about a second's work, without slices.
bool wants_choice(const v1::Scene& scene);

/// The most units of work that it then takes for the choice.
double most_choice_work();

}  // namespace stiefel::server
