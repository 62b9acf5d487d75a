#include <algorithm>

#include "server/calls/service.h"
#include "server/convert/geodesics/geodesic_answers.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {

void Connect(ServerCall& call, const v1::ConnectRequest& request, Writer& writer) {
  call.hold(memory_price({.request = held_by(request)}));
  const ConnectTask task = read(request);
  // A search on each thread, fewer where they would take more than an eighth of the memory.
  const std::uint64_t reply = answer_bytes(task), each = search_bytes(task) + reply;
  const std::uint64_t fit = call.account().memory().limit() / 8 / each;
  const auto threads = static_cast<std::uint64_t>(call.host().threads);
  const std::size_t at_once =
      std::clamp<std::uint64_t>(fit, 1, std::min<std::uint64_t>(task.problems.size(), threads));
  call.hold(memory_price({.workspace = at_once * each,
                          .reply = reply,
                          .reply_of = request.steps() > 0 ? "steps" : "samples"}));
  call.pass();
  join(task, at_once, call.stop(),
       [&](v1::ConnectResponse& answer) { call.write(writer, answer); });
}

}  // namespace stiefel::server
