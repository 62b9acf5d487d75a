#include "server/convert/errors.h"

#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <initializer_list>
#include <new>

#include "engine/numbers/to_text.h"
#include "server/convert/memory_price.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"
#include "stiefel/v1/run.pb.h"

namespace stiefel::server {

void check(Faults& faults) {
  if (faults.empty()) return;
  const FoundFaults found = faults.take();
  throw errors::invalid(found.violations, found.more);
}

namespace errors {
namespace {

// Status and details are sent in trailers, of which clients accept 8 KiB.
constexpr std::size_t max_text = 200;
constexpr std::size_t max_total = 2000;
constexpr std::size_t max_checkpoint = 4096;
constexpr std::chrono::seconds to_a_free_session{1}, to_free_memory{1}, to_a_free_store{1};

/// Shortens to `max_text` bytes, without cutting through a UTF-8 character.
std::string shortened(std::string_view text) {
  if (text.size() <= max_text) return std::string(text);
  std::size_t end = max_text;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return std::string(text.substr(0, end)) + "...";
}

void add_detail(std::string_view type, const google::protobuf::Message& detail,
                v1::Status& status) {
  auto* any = status.add_details();
  any->set_type_url("type.googleapis.com/google.rpc." + std::string(type));
  any->set_value(detail.SerializeAsString());
}

/// Returns the first detail of a type; nothing if there is none.
template <class Detail>
std::optional<Detail> detail_of(const grpc::Status& status, std::string_view type) {
  v1::Status details;
  Detail detail;
  if (details.ParseFromString(status.error_details()))
    for (const auto& any : details.details())
      if (any.type_url().ends_with(type) && detail.ParseFromString(any.value())) return detail;
  return std::nullopt;
}

StatusError make(grpc::StatusCode code, const std::string& message, v1::Status status) {
  status.set_code(code);
  status.set_message(message);
  return StatusError({code, message, status.SerializeAsString()});
}

using Metadata = std::initializer_list<std::pair<const char*, std::string_view>>;

void add_info(const std::string& reason, const auto& metadata, v1::Status& status) {
  v1::ErrorInfo detail;
  detail.set_reason(reason);
  detail.set_domain("stiefel");
  for (const auto& [key, value] : metadata) (*detail.mutable_metadata())[key] = shortened(value);
  add_detail("ErrorInfo", detail, status);
}

StatusError info(grpc::StatusCode code, const std::string& message, const char* reason,
                 Metadata metadata = {}) {
  v1::Status status;
  add_info(reason, metadata, status);
  return make(code, message, std::move(status));
}

/// RESOURCE_EXHAUSTED with an ErrorInfo, a QuotaFailure of `subject`, and a RetryInfo unless
/// waiting does not help, so that `retry_after` is 0.
StatusError exhausted(const std::string& message, const char* reason, Metadata metadata,
                      const char* subject, const std::string& description,
                      std::chrono::milliseconds retry_after) {
  v1::Status status;
  add_info(reason, metadata, status);
  v1::QuotaFailure quota;
  quota.add_violations()->set_subject(subject);
  quota.mutable_violations(0)->set_description(description);
  add_detail("QuotaFailure", quota, status);
  if (retry_after.count() > 0) {
    v1::RetryInfo retry;
    *retry.mutable_retry_delay() =
        google::protobuf::util::TimeUtil::MillisecondsToDuration(retry_after.count());
    add_detail("RetryInfo", retry, status);
  }
  return make(grpc::RESOURCE_EXHAUSTED, message, std::move(status));
}

}  // namespace

StatusError invalid(const Violations& violations, std::size_t more) {
  v1::BadRequest detail;
  std::string message;
  std::size_t told = 0;
  for (const Violation& violation : violations) {
    const std::string field = shortened(violation.field);
    const std::string value = shortened(violation.value);
    const std::string description = value.empty() ? violation.rule : value + ": " + violation.rule;
    if (message.size() + field.size() + description.size() > max_total) break;
    if (told++ > 0) message += "; ";
    message += field + ": " + description;
    auto* entry = detail.add_field_violations();
    entry->set_field(field);
    entry->set_description(description);
  }
  more += violations.size() - told;
  if (more > 0) message += "; and " + std::to_string(more) + " more";
  v1::Status status;
  add_detail("BadRequest", detail, status);
  const auto why = std::ranges::find_if_not(violations, &std::string::empty, &Violation::reason);
  if (why != violations.end()) add_info(why->reason, why->metadata, status);
  return make(grpc::INVALID_ARGUMENT, message, std::move(status));
}

StatusError invalid(std::string field, std::string value, std::string rule) {
  return invalid({{std::move(field), std::move(value), std::move(rule)}});
}

StatusError no_session(std::string_view id, bool deleted, const char* field) {
  const std::string what = deleted ? ": this session was deleted" : ": there is no such session";
  return info(grpc::NOT_FOUND, std::string(field) + ": " + shortened(id) + what,
              deleted ? "SESSION_DELETED" : "SESSION_NOT_FOUND", {{"session_id", id}});
}

StatusError session_has_other_scene(std::string_view id) {
  return info(grpc::ALREADY_EXISTS,
              "session_id: " + shortened(id) + ": a session with this id and another scene exists",
              "SESSION_HAS_OTHER_SCENE", {{"session_id", id}});
}

StatusError too_many_sessions(std::uint32_t max_sessions) {
  const std::string limit = std::to_string(max_sessions);
  return exhausted("this server holds at most " + limit + " sessions: delete one or wait",
                   "TOO_MANY_SESSIONS", {{"max_sessions", limit}}, "sessions", "at most " + limit,
                   to_a_free_session);
}

StatusError time_reached(double seconds) {
  const std::string most = to_text(seconds);
  const std::string description = "the limit is " + most + " s of computing for a call";
  return exhausted(
      "call_seconds: " + description +
          " (--max-call-seconds): request fewer steps; the session keeps the state that "
          "was reached",
      "OVER_QUOTA", {{"limit", "call_seconds"}, {"most", most}}, "call_seconds", description, {});
}

StatusError over_quota(const Refusal& refusal) {
  const std::string most = to_text(refusal.most), asked = to_text(refusal.asked);
  const std::string description =
      "the limit is " + most + "; this call would raise the use to " + asked;
  const auto wait = refusal.retry_after.count();
  const std::string advice = wait > 0 ? ": wait " + std::to_string(wait) + " ms" : ": request less";
  return exhausted(std::string(refusal.limit) + ": " + description + advice, "OVER_QUOTA",
                   {{"limit", refusal.limit}, {"most", most}, {"asked", asked}}, refusal.limit,
                   description, refusal.retry_after);
}

std::optional<std::chrono::milliseconds> retry_delay(const grpc::Status& status) {
  const auto retry = detail_of<v1::RetryInfo>(status, "/google.rpc.RetryInfo");
  if (!retry) return std::nullopt;
  const auto delay = google::protobuf::util::TimeUtil::DurationToNanoseconds(retry->retry_delay());
  return std::chrono::ceil<std::chrono::milliseconds>(std::chrono::nanoseconds(delay));
}

Reason reason(const grpc::Status& status) {
  const auto info = detail_of<v1::ErrorInfo>(status, "/google.rpc.ErrorInfo");
  if (!info) return {};
  const auto limit = info->metadata().find("limit");
  const bool named = info->reason() == "OVER_QUOTA" && limit != info->metadata().end();
  return {info->reason(), named ? limit->second : ""};
}

StatusError checkpoint_refused(const CheckpointRefusal& refusal, std::size_t bytes,
                               std::string_view from) {
  const std::string &theirs = refusal.numerics_id, &ours = numerics_id();
  if (refusal.fault == CheckpointFault::other_numerics)
    return info(grpc::FAILED_PRECONDITION,
                "checkpoint: written with the numerics id " + shortened(theirs) +
                    ", this server has " + ours + ": the bits could differ",
                "CHECKPOINT_OF_OTHER_NUMERICS",
                {{"checkpoint_numerics_id", theirs}, {"server_numerics_id", ours}});
  return invalid("checkpoint", std::to_string(bytes) + " bytes",
                 refusal.fault == CheckpointFault::other_scene
                     ? "must come from a session of the same scene"
                     : "is damaged: must be the bytes that " + std::string(from) + " returned");
}

StatusError reply_too_large(const char* field, std::uint64_t size) {
  const std::string bytes = std::to_string(size), most = std::to_string(max_reply_bytes);
  return invalid({{field,
                   bytes + " bytes",
                   "a reply has at most " + most,
                   "REPLY_TOO_LARGE",
                   {{"bytes", bytes}, {"max_bytes", most}}}});
}

StatusError overflow(const Place& place, const Overflow& overflow) {
  return invalid({place.of({"", overflow.field + " = " + to_text(overflow.value) + " at step 0",
                            "numbers are so large or so small that a field overflows"})});
}

StatusError outside_domain(const OutsideDomain& outside) {
  const std::string value = to_text(outside.value), bound = to_text(outside.bound);
  std::string where = "outside the domain " + std::string(outside.domain);
  Violation violation{
      outside.field,
      {},
      {},
      "OUTSIDE_DOMAIN",
      {{"domain", std::string(outside.domain)}, {"value", value}, {"bound", bound}}};
  violation.rule = where + ": the value is " + value + ", the bound " + bound;
  return invalid({std::move(violation)});
}

StatusError unequal_determinants(const std::string& field, int Q_0, int Q_T) {
  const std::string first = std::to_string(Q_0), last = std::to_string(Q_T);
  return info(
      grpc::INVALID_ARGUMENT,
      field + ": det Q_0 = " + first + " and det Q_T = " + last + ": no path of frames joins them",
      "UNEQUAL_DETERMINANTS", {{"Q_0", first}, {"Q_T", last}});
}

StatusError shutting_down() {
  return info(grpc::UNAVAILABLE, "the server is shutting down", "SHUTTING_DOWN");
}

StatusError shutting_down(const Session& session, const Simulation& at) {
  StatusError error = shutting_down();
  if (checkpoint_bytes(session) > max_checkpoint) return error;
  v1::Checkpoint checkpoint;
  checkpoint.set_step(at.step());
  checkpoint.set_data(encode_checkpoint(session, at));
  v1::Status status;
  to_proto(error.status, &status);
  status.add_details()->PackFrom(checkpoint);
  return make(error.status.error_code(), error.status.error_message(), std::move(status));
}

StatusError token_missing() {
  return info(grpc::UNAUTHENTICATED,
              "this server needs a token: send the metadata 'authorization: Bearer TOKEN'",
              "TOKEN_MISSING");
}

StatusError token_unknown() {
  return info(grpc::UNAUTHENTICATED, "the token is unknown or was withdrawn", "TOKEN_UNKNOWN");
}

StatusError cancelled() { return StatusError({grpc::CANCELLED, "the caller cancelled"}); }

StatusError out_of_memory() {
  try {
    return exhausted("out of memory", "OUT_OF_MEMORY", {}, "memory", "out of memory",
                     to_free_memory);
  } catch (const std::bad_alloc&) {
    // A string so short allocates nothing.
    return StatusError({grpc::RESOURCE_EXHAUSTED, "out of memory"});
  }
}

StatusError not_written(const WriteFault& fault) {
  const std::string reason = ": " + shortened(fault.what);
  switch (fault.kind) {
    case WriteFault::Kind::full:
      return exhausted("there is no space in the store" + reason, "STORE_FULL", {}, "store",
                       shortened(fault.what), to_a_free_store);
    case WriteFault::Kind::unavailable:
    case WriteFault::Kind::locked:
      return info(grpc::UNAVAILABLE, "the store cannot write now; try again" + reason,
                  "STORE_UNAVAILABLE");
    case WriteFault::Kind::damaged:
      return info(grpc::INTERNAL, "the store is damaged" + reason, "STORE_DAMAGED");
    case WriteFault::Kind::out_of_memory:
      break;
  }
  return out_of_memory();
}

StatusError memory_exhausted(const MemoryExhausted& refused) {
  const auto wait = refused.can_ever_fit() ? to_free_memory : std::chrono::seconds(0);
  if (refused.part()) {
    const std::uint64_t used = refused.limit() - refused.free();
    return over_quota({refused.part(), static_cast<double>(refused.limit()),
                       static_cast<double>(used + refused.bytes()), wait});
  }
  const std::string bytes = std::to_string(refused.bytes());
  const std::string free = std::to_string(refused.free());
  const std::string limit = std::to_string(refused.limit());
  return exhausted(refused.what(), "MEMORY_LIMIT",
                   {{"bytes", bytes}, {"free", free}, {"limit", limit}}, "memory", refused.what(),
                   wait);
}

StatusError internal(std::string_view what) {
  return info(grpc::INTERNAL, shortened(what), "INTERNAL_ERROR");
}

void to_proto(const grpc::Status& status, v1::Status* out) {
  if (out->ParseFromString(status.error_details()) && out->code() == status.error_code()) return;
  out->Clear();
  out->set_code(status.error_code());
  out->set_message(status.error_message());
}

grpc::Status from_current_exception() {
  try {
    throw;
  } catch (const StatusError& error) {
    return error.status;
  } catch (const std::bad_alloc&) {
    return out_of_memory();
  } catch (const Stopped&) {
    return cancelled();
  } catch (const MemoryExhausted& refused) {
    return memory_exhausted(refused);
  } catch (const std::exception& exception) {
    return internal(exception.what());
  } catch (...) {
    return internal("an exception of unknown type");
  }
}

}  // namespace errors
}  // namespace stiefel::server
