#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "server/convert/resolve.h"
#include "server/sessions/session.h"
#include "stiefel/v1/summary.pb.h"

namespace stiefel::server {

/// Returns a digest of everything in a request that determines its summary.
std::uint64_t digest_of(v1::SummarizeRequest request);

/// Returns the saved summary in the request's checkpoint, a view into the request; nothing if the
/// checkpoint is to be ignored because this server does not have its key; or INVALID_ARGUMENT or
/// FAILED_PRECONDITION with the reason why it is refused.
OrStatus<std::optional<std::string_view>> open_checkpoint(const Session& session,
                                                          const v1::SummarizeRequest& request);

/// INVALID_ARGUMENT: the checkpoint of a request is damaged.
grpc::Status damaged_checkpoint(const v1::SummarizeRequest& request);

}  // namespace stiefel::server
