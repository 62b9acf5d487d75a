#pragma once

#include <grpcpp/support/status.h>

#include <cstdint>
#include <vector>

#include "server/convert/convert.h"
#include "server/scheduling/account.h"
#include "server/sessions/cursor.h"

namespace stiefel::server {

/// A checked Step request.
struct StepTask {
  std::int64_t to = 0;
  std::vector<std::size_t> fields;
  bool return_checkpoint = false;
};

/// Returns the bytes of memory that the reply takes while it is made and sent.
std::uint64_t step_memory(const Session& session, const StepTask& task);

/// Returns REPLY_TOO_LARGE if the reply is too large to send.
grpc::Status check_size(const Session& session, const StepTask& task);

/// Writes the reply at the step where the cursor ended.
void answer_step(const Session& session, const Cursor& cursor, const StepTask& task,
                 v1::StepResponse* response);

/// Steps on the calling thread and charges the account if that is expected to take less than
/// `inline_nanoseconds`; returns whether it did.
bool step_inline(Session& session, const StepTask& task, Account& account,
                 v1::StepResponse* response);

}  // namespace stiefel::server
