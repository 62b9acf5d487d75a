#include "server/calls/service.h"
#include "server/convert/answers.h"
#include "server/convert/memory_price.h"
#include "server/convert/resolve.h"

namespace stiefel::server {
void Convert(ServerCall& call, const v1::ConvertRequest& request,
             grpc::ServerWriter<v1::ConvertResponse>& writer) {
  ConversionAnswer answer(
      request, MemoryLease(call.account().memory(),
                           memory_price({held_by(request), 2 * scene_workspace(request.scene())})));
  for (v1::ConvertResponse message; !answer.done(); call.write(writer, message, answer.done()))
    answer.next(message);
}

}  // namespace stiefel::server
