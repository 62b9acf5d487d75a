#include <algorithm>
#include <chrono>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/memory_price.h"
#include "server/convert/stream_answer.h"

namespace stiefel::server {

void Stream(ServerCall& call, const v1::StreamRequest& request, Writer& writer) {
  constexpr std::chrono::milliseconds longest_look{50};
  const SessionRef session = call.session(request.session_id());
  check_range(request);
  const auto fields = select_fields(*session, request.fields());
  const Sampling::Range range{request.from(), request.to(),
                              std::max<std::int64_t>(request.every(), 1),
                              request.checkpoint_every(), request.return_checkpoint()};
  call.hold(stream_memory(*session, fields, range));
  const auto place = [&] {
    Account& account = call.account();
    auto taken = account.large_stream({});
    for (; !taken; call.pass())
      taken = call.without_place([&] { return account.large_stream(longest_look); });
    return taken;
  };
  StreamAnswer answer(*session, fields, range, place);
  send_results<v1::StreamResponse>(call, writer, answer, until_results, 0,
                                   [&](double) { answer.advance(call.stop()); });
}

}  // namespace stiefel::server
