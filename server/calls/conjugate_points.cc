#include "server/calls/service.h"
#include "server/convert/geodesics/geodesic_answers.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {

void ConjugatePoints(ServerCall& call, const v1::ConjugatePointsRequest& request,
                     v1::ConjugatePointsResponse* response) {
  call.hold(memory_price({held_by(request)}));
  answer(request, call.memory(), call.stop(), response);
  call.pass();
}

}  // namespace stiefel::server
