#pragma once

#include <grpcpp/support/status.h>

#include <cstdint>
#include <vector>

#include "server/convert/convert.h"
#include "server/scheduling/account.h"
#include "server/sessions/cursor.h"

namespace stiefel::server {

/// What a Step asks for, once it is checked.
struct StepTask {
  std::int64_t to = 0;
  std::vector<std::size_t> fields;
  bool return_checkpoint = false;
  bool checksum = false;
};

/// Bytes of memory that the reply takes while it is made and sent.
std::uint64_t step_memory(const Session& session, const StepTask& task);

/// REPLY_TOO_LARGE if the reply would be.
grpc::Status check_size(const Session& session, const StepTask& task);

/// The reply from where the cursor ended.
void answer_step(const Session& session, const Cursor& cursor, const StepTask& task,
                 v1::StepResponse* response);

/// Does it here and now, and lets the account pay, if that is expected to take less than
/// `inline_nanoseconds`.
bool step_inline(Session& session, const StepTask& task, Account& account,
                 v1::StepResponse* response);

}  // namespace stiefel::server
