#include <utility>

#include "server/calls/service.h"
#include "server/convert/answers.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {

void MeasureTradeoff(ServerCall& call, const v1::MeasureTradeoffRequest& request, Writer& writer) {
  call.hold(memory_price({held_by(request), 2 * scene_workspace(request.scene())}));
  TradeoffRequest wanted = read(request);
  const std::uint64_t workspace = tradeoff_workspace(wanted.scene);
  const auto tradeoff = value_of(Tradeoff::prepare(std::move(wanted)));
  call.hold(workspace);
  v1::MeasureTradeoffResponse message;
  const auto send = [&](bool last = false) {
    call.pass();  // a measurement that a stop interrupted is not valid
    message.set_work(call.work());
    call.write(writer, message, last);
  };
  to_proto(value_of(tradeoff->solve_reference(call.stop())), message.mutable_setup());
  send();
  while (const auto point = tradeoff->next(call.stop())) {
    to_proto(*point, message.mutable_point());
    send();
  }
  for (const std::size_t i : tradeoff->front())
    message.mutable_front()->add_points(static_cast<std::uint32_t>(i));
  send(true);
}

}  // namespace stiefel::server
