#include "server/calls/service.h"
#include "server/convert/answers.h"
#include "server/convert/memory_price.h"
#include "server/convert/resolve.h"

namespace stiefel::server {
void MeasureTradeoff(ServerCall& call, const v1::MeasureTradeoffRequest& request,
                     grpc::ServerWriter<v1::MeasureTradeoffResponse>& writer) {
  TradeoffAnswer answer(
      request, MemoryLease(call.account().memory(),
                           memory_price({held_by(request), 2 * scene_workspace(request.scene())})));
  for (v1::MeasureTradeoffResponse message; !answer.done();
       call.write(writer, message, answer.done())) {
    answer.next(call.stop(), message);
    call.pass();  // a measurement that a stop interrupted is not valid
  }
}

}  // namespace stiefel::server
