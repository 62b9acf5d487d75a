#pragma once

#include <cstdint>
#include <vector>

#include "server/calls/server_call.h"
#include "server/convert/convert.h"
#include "server/sessions/cursor.h"

namespace stiefel::server {

/// A checked Step request.
struct StepTask {
  std::int64_t to = 0;
  std::vector<std::size_t> fields;
  bool return_checkpoint = false;
};

/// Returns the bytes of memory that the reply takes while it is made and sent. Throws StatusError,
/// REPLY_TOO_LARGE.
std::uint64_t step_memory(const Session& session, const StepTask& task);

/// Computes to the step of the task and writes the reply.
void step(ServerCall& call, Session& session, const StepTask& task, v1::StepResponse* response);

}  // namespace stiefel::server
