#include <mutex>
#include <utility>

#include "server/calls/service.h"
#include "server/convert/geodesics/geodesic_answers.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {
void Connect(ServerCall& call, const v1::ConnectRequest& request,
             grpc::ServerWriter<v1::ConnectResponse>& writer) {
  call.hold(memory_price({.request = held_by(request)}));
  ConnectTask task = read(request);
  constexpr std::uint64_t part_of_memory = 8;
  const std::uint64_t workspace = connect_workspace(request);
  const std::size_t at_once = searches_at_once(request, workspace, call.host().threads,
                                               call.account().memory().limit() / part_of_memory);
  call.memory().grow_to(call.memory().bytes() + at_once * workspace +
                        waiting_answers_bytes(request));
  ConnectAnswer answer(std::move(task), at_once);
  v1::ConnectResponse message;
  std::mutex sending;
  const auto send = [&] {
    const std::lock_guard lock(sending);
    while (answer.next(message)) call.write(writer, message);
  };
  do {
    call.pass();
    answer.join(
        call.stop(), [] { return false; }, send);
    call.pass();  // a search that a stop interrupted has no answer
    send();
  } while (!answer.done());
}

}  // namespace stiefel::server
