#include "server/convert/summary/checkpoint.h"

#include <algorithm>
#include <string>

#include "server/convert/errors.h"
#include "server/sessions/checkpoints/summary_checkpoint.h"
#include "server/sessions/identity.h"
#include "server/sessions/numerics_id.h"

namespace stiefel::server {
namespace {

grpc::Status refuse(const v1::SummarizeRequest& request, const char* rule) {
  return errors::invalid("checkpoint", std::to_string(request.checkpoint().size()) + " bytes",
                         rule);
}

}  // namespace

std::uint64_t digest_of(v1::SummarizeRequest request) {
  request.clear_session_id();
  request.clear_checkpoint();
  request.clear_checkpoint_every();
  request.clear_return_checkpoint();
  request.set_every(std::max<std::int64_t>(request.every(), 1));
  return hash(request.SerializeAsString());
}

OrStatus<std::optional<std::string_view>> open_checkpoint(const Session& session,
                                                          const v1::SummarizeRequest& request) {
  const auto saved = decode_summary(session, digest_of(request), request.checkpoint());
  if (saved) return *saved;
  switch (saved.error().fault) {
    case SummaryFault::other_numerics:
      return std::unexpected(
          errors::checkpoint_of_other_numerics(saved.error().numerics_id, numerics_id()));
    case SummaryFault::other_scene:
      return std::unexpected(refuse(request, "must come from a session of the same scene"));
    case SummaryFault::other_request:
      return std::unexpected(refuse(request, "must come from a Summarize of the same request"));
    case SummaryFault::foreign:
      return std::nullopt;
    case SummaryFault::corrupt:
      break;
  }
  return std::unexpected(damaged_checkpoint(request));
}

grpc::Status damaged_checkpoint(const v1::SummarizeRequest& request) {
  return refuse(request, "is damaged: must be the bytes that Summarize returned");
}

}  // namespace stiefel::server
