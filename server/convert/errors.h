#pragma once

#include <grpcpp/support/status.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "engine/representations/outside_domain.h"
#include "stiefel/scene.h"

/// Every error the service answers with, and nothing else does. The message is for people; the
/// details say the same to programs (error.proto).
namespace stiefel::server::errors {

/// INVALID_ARGUMENT: "field: value: rule", and the same as a BadRequest; with the reason of a fault
/// that has one: TOLERANCE_NOT_MET with `tolerance`, `best_error` and `best_method`.
grpc::Status invalid(const Violations& violations);
grpc::Status invalid(std::string field, std::string value, std::string rule);
/// NOT_FOUND, SESSION_NOT_FOUND with `session_id`.
grpc::Status session_not_found(std::string_view id, const char* field = "session_id");
/// ALREADY_EXISTS, SESSION_HAS_OTHER_SCENE with `session_id`.
grpc::Status session_has_other_scene(std::string_view id);
/// RESOURCE_EXHAUSTED, TOO_MANY_SESSIONS with `max_sessions`.
grpc::Status too_many_sessions(std::uint32_t max_sessions);
/// FAILED_PRECONDITION, CHECKPOINT_OF_OTHER_BUILD with `checkpoint_build` and `server_build`.
grpc::Status checkpoint_of_other_build(std::string_view theirs, std::string_view ours);
/// INVALID_ARGUMENT, OUTSIDE_DOMAIN with `domain`, `value` and `bound`.
grpc::Status outside_domain(const OutsideDomain& outside);
/// INVALID_ARGUMENT, UNEQUAL_DETERMINANTS with `Q_0` and `Q_T`.
grpc::Status unequal_determinants(int Q_0, int Q_T);
/// UNAVAILABLE, SHUTTING_DOWN.
grpc::Status shutting_down();
/// CANCELLED: the caller went away.
grpc::Status cancelled();
/// RESOURCE_EXHAUSTED, OUT_OF_MEMORY.
grpc::Status out_of_memory();
/// INTERNAL, INTERNAL_ERROR: a fault of ours.
grpc::Status internal(std::string_view what);

/// The status for the exception being handled.
grpc::Status from_current_exception();

}  // namespace stiefel::server::errors
