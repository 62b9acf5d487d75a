#pragma once

#include <grpcpp/support/status.h>

#include <cstdint>
#include <expected>
#include <string_view>
#include <vector>

#include "server/calls/host.h"
#include "server/convert/convert.h"
#include "stiefel/conversion.h"

/// What is checked before anything moves.
namespace stiefel::server {

template <class T>
using OrStatus = std::expected<T, grpc::Status>;

/// UNAVAILABLE when shutting down, NOT_FOUND, or the session.
OrStatus<SessionLease> find_session(const Host& host, std::string_view id,
                                    const char* field = "session_id");

/// INVALID_ARGUMENT unless it is 1 to 128 of [A-Za-z0-9._-].
grpc::Status check_session_id(std::string_view id, const char* field = "session_id");

/// INVALID_ARGUMENT unless low <= value <= Session::max_step.
grpc::Status check_step(const char* field, std::int64_t value, std::int64_t low = 0);

/// The resolved scene, or INVALID_ARGUMENT with the paths below `field`.
OrStatus<Scene> read_scene(bool present, const v1::Scene& scene, const char* field = "scene");

/// Whether to resolve it is about a second's work, without slices.
bool wants_choice(const v1::Scene& scene);

/// A session of that scene under that id, new or there already; or why there is none. `place`: of
/// the scene in the request.
OrStatus<Registry::Created> admit(Host& host, const std::string& id, Scene scene,
                                  const Place& place, std::string_view checkpoint = {});

/// A conversion's refusal as an error.
grpc::Status refused(const ConversionRefusal& refusal);

}  // namespace stiefel::server
