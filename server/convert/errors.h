#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/convert/faults.h"
#include "server/limits/memory_budget.h"
#include "server/scheduling/quota.h"
#include "server/sessions/ledger.h"
#include "server/sessions/session.h"
#include "stiefel/outside_domain.h"
#include "stiefel/scene.h"
#include "stiefel/v1/error.pb.h"

/// All errors with which the service answers; no other code makes one. The message is for people,
/// the details say the same to programs (error.proto).
namespace stiefel::server::errors {

/// INVALID_ARGUMENT: "field: value: rule", and the same as a BadRequest; at the end "and N more"
/// for the violations that have no room, and for `more` others that were counted only. If a
/// violation has a reason, also that: TOLERANCE_NOT_MET with `tolerance`, `most_work` and, where
/// they are known, `best_error`, `best_method` and `reference_work`.
grpc::Status invalid(const Violations& violations, std::size_t more = 0);
grpc::Status invalid(const FoundFaults& refused);
grpc::Status invalid(std::string field, std::string value, std::string rule);
/// NOT_FOUND, SESSION_NOT_FOUND with `session_id`.
grpc::Status session_not_found(std::string_view id, const char* field = "session_id");
/// NOT_FOUND, SESSION_DELETED with `session_id`: clients must not create the session again.
grpc::Status session_deleted(std::string_view id, const char* field = "session_id");
/// ALREADY_EXISTS, SESSION_HAS_OTHER_SCENE with `session_id`.
grpc::Status session_has_other_scene(std::string_view id);
/// RESOURCE_EXHAUSTED, TOO_MANY_SESSIONS with `max_sessions`; a QuotaFailure, and a RetryInfo,
/// since a session may expire or be deleted by then.
grpc::Status too_many_sessions(std::uint32_t max_sessions);
/// RESOURCE_EXHAUSTED, PRICE_REACHED with `work` and `step`; a QuotaFailure for `price`, and a
/// RetryInfo, since the session keeps the state at that step, from which the next call goes on.
grpc::Status price_reached(const PriceReached& reached);
/// RESOURCE_EXHAUSTED, OVER_QUOTA with `limit`, `most` and `asked`; a QuotaFailure whose subject is
/// the limit, and a RetryInfo unless waiting does not help.
grpc::Status over_quota(const Refusal& refusal);
/// Returns the delay of a status's RetryInfo, rounded up; nothing if it has none.
std::optional<std::chrono::milliseconds> retry_delay(const grpc::Status& status);
/// The reason of a status's ErrorInfo, and the limit that it names; empty where absent.
struct Reason {
  std::string reason, limit;
};
Reason reason(const grpc::Status& status);
/// FAILED_PRECONDITION, CHECKPOINT_OF_OTHER_NUMERICS with `checkpoint_numerics_id` and
/// `server_numerics_id`.
grpc::Status checkpoint_of_other_numerics(std::string_view theirs, std::string_view ours);
/// INVALID_ARGUMENT for `fields`, REPLY_TOO_LARGE with `bytes` and `max_bytes`; Stream sends such a
/// reply in parts.
grpc::Status reply_too_large(std::size_t bytes);
/// INVALID_ARGUMENT: a scene whose field is not finite at step 0.
grpc::Status overflow(const Place& place, const Overflow& overflow);
/// INVALID_ARGUMENT for `outside.field`, OUTSIDE_DOMAIN with `domain`, `value` and `bound`.
grpc::Status outside_domain(const OutsideDomain& outside);
/// INVALID_ARGUMENT, UNEQUAL_DETERMINANTS with `Q_0` and `Q_T`, the two signs.
grpc::Status unequal_determinants(const std::string& field, int Q_0, int Q_T);
/// UNAVAILABLE, SHUTTING_DOWN.
grpc::Status shutting_down();
/// UNAUTHENTICATED, TOKEN_MISSING: the call has no metadata `authorization`.
grpc::Status token_missing();
/// UNAUTHENTICATED, TOKEN_UNKNOWN: the metadata `authorization` holds no token of this server, or
/// one that was withdrawn.
grpc::Status token_unknown();
/// CANCELLED: the caller went away; also for Stopped (stop.h).
grpc::Status cancelled();
/// RESOURCE_EXHAUSTED, OUT_OF_MEMORY; a QuotaFailure for `memory`, and a RetryInfo.
grpc::Status out_of_memory();
/// A session or its deletion is not on disk: RESOURCE_EXHAUSTED with STORE_FULL, a QuotaFailure for
/// `store` and a RetryInfo, since deletions make room; or with OUT_OF_MEMORY; UNAVAILABLE with
/// STORE_UNAVAILABLE, when a retry may succeed; INTERNAL with STORE_DAMAGED.
grpc::Status not_written(const WriteFault& fault);
/// RESOURCE_EXHAUSTED, MEMORY_LIMIT with `bytes`, `free` and `limit`; a QuotaFailure for `memory`,
/// and a RetryInfo if the bytes can fit once others are given back. For a part of the memory, the
/// error of `over_quota`.
grpc::Status memory_exhausted(const MemoryExhausted& refused);
/// INTERNAL, INTERNAL_ERROR: a fault of the server itself.
grpc::Status internal(std::string_view what);

/// Converts a status with its details to a message.
void to_proto(const grpc::Status& status, v1::Status* out);

/// Returns the status for the exception being handled.
grpc::Status from_current_exception();

}  // namespace stiefel::server::errors
