#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <cstdint>
#include <exception>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/convert/faults.h"
#include "server/scheduling/memory_budget.h"
#include "server/scheduling/principal.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/pending_write.h"
#include "server/sessions/server_session.h"
#include "stiefel/outside_domain.h"
#include "stiefel/scene.h"
#include "stiefel/v1/common.pb.h"

namespace stiefel::server {

/// Ends a call, or the answer to one request of a Drive, with that status.
struct StatusError : std::exception {
  explicit StatusError(grpc::Status of_call) : status(std::move(of_call)) {}
  operator grpc::Status() && { return std::move(status); }  // NOLINT(google-explicit-constructor)
  grpc::Status status;
};

/// Throws INVALID_ARGUMENT if there are faults.
void check(Faults& faults);

}  // namespace stiefel::server

/// All errors with which the service answers; no other code makes one. The message is for people,
/// the details say the same to programs (common.proto).
namespace stiefel::server::errors {

/// INVALID_ARGUMENT: "field: value: rule", and the same as a BadRequest; at the end "and N more"
/// for the violations that have no room, and for `more` others that were counted only. If a
/// violation has a reason (TOLERANCE_NOT_MET, REPLY_TOO_LARGE, OUTSIDE_DOMAIN), also that.
StatusError invalid(const Violations& violations, std::size_t more = 0);
StatusError invalid(std::string field, std::string value, std::string rule);
/// INVALID_ARGUMENT: the field of the request that makes a reply of so many bytes.
StatusError reply_too_large(const char* field, std::uint64_t bytes);
/// INVALID_ARGUMENT: a scene whose field is not finite at step 0.
StatusError overflow(const Place& place, const Overflow& overflow);
StatusError outside_domain(const OutsideDomain& outside);
/// INVALID_ARGUMENT, UNEQUAL_DETERMINANTS with `Q_0` and `Q_T`, the two signs.
StatusError unequal_determinants(const std::string& field, int Q_0, int Q_T);

/// NOT_FOUND, SESSION_NOT_FOUND or, for a deleted one, SESSION_DELETED (clients must not create the
/// session again).
StatusError no_session(std::string_view id, bool deleted, const char* field = "session_id");
/// ALREADY_EXISTS, SESSION_HAS_OTHER_SCENE.
StatusError session_has_other_scene(std::string_view id);
/// FAILED_PRECONDITION, CHECKPOINT_OF_OTHER_NUMERICS; INVALID_ARGUMENT for `checkpoint`, of so many
/// bytes, that is of another scene or not what the RPCs that `from` names return.
StatusError checkpoint_refused(const CheckpointRefusal& refusal, std::size_t bytes,
                               std::string_view from);

/// RESOURCE_EXHAUSTED with a QuotaFailure, and a RetryInfo unless waiting does not help:
/// TOO_MANY_SESSIONS;
StatusError too_many_sessions(std::uint32_t max_sessions);
/// OVER_QUOTA of the limit "call_seconds", for a call that has computed for so long;
StatusError time_reached(double seconds);
/// OVER_QUOTA, whose subject is the limit;
StatusError over_quota(const Refusal& refusal);
/// MEMORY_LIMIT, or for a part of the memory OVER_QUOTA;
StatusError memory_exhausted(const MemoryExhausted& refused);
/// OUT_OF_MEMORY.
StatusError out_of_memory();
/// A change is not on disk: RESOURCE_EXHAUSTED with STORE_FULL or OUT_OF_MEMORY, UNAVAILABLE with
/// STORE_UNAVAILABLE when a retry may succeed, INTERNAL with STORE_DAMAGED.
StatusError not_written(const WriteFault& fault);

/// UNAVAILABLE, SHUTTING_DOWN; for a run that stopped at a state with the Checkpoint of that state,
/// if it fits into trailers.
StatusError shutting_down();
StatusError shutting_down(const Session& session, const Simulation& at);
/// UNAUTHENTICATED: the call has no metadata `authorization`, or no token of this server in it.
StatusError token_missing();
StatusError token_unknown();
/// CANCELLED: the caller went away; also for Stopped (stop.h), of which a call that has its caller
/// makes `shutting_down` (call.h).
StatusError cancelled();
/// INTERNAL, INTERNAL_ERROR: a fault of the server itself.
StatusError internal(std::string_view what);

/// Returns the delay of a status's RetryInfo, rounded up; nothing if it has none.
std::optional<std::chrono::milliseconds> retry_delay(const grpc::Status& status);
/// The reason of a status's ErrorInfo, and the limit that it names; empty where absent.
struct Reason {
  std::string reason, limit;
};
Reason reason(const grpc::Status& status);
/// Converts a status with its details to a message.
void to_proto(const grpc::Status& status, v1::Status* out);

/// Returns the status for the exception being handled.
grpc::Status from_current_exception();

}  // namespace stiefel::server::errors

namespace stiefel::server {

/// Returns the value, or throws INVALID_ARGUMENT with the violations at their place.
template <class T>
T value_of(std::expected<T, Violations> checked, const Place& place = in_the_request) {
  if (!checked) throw errors::invalid(place.of(std::move(checked.error())));
  return *std::move(checked);
}

}  // namespace stiefel::server
