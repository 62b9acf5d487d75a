#include "server/calls/service.h"
#include "server/convert/geodesics/geodesic_answers.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {
void ConjugatePoints(ServerCall& call, const v1::ConjugatePointsRequest& request,
                     grpc::ServerWriter<v1::ConjugatePointsResponse>& writer) {
  ConjugateAnswer answer(request,
                         MemoryLease(call.account().memory(), memory_price({held_by(request)})));
  for (v1::ConjugatePointsResponse message; !answer.done();
       call.write(writer, message, answer.done())) {
    answer.next(call.stop(), message);
    call.pass();
  }
}

}  // namespace stiefel::server
