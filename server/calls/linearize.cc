#include "server/calls/moved_vectors.h"
#include "server/convert/tangents/linearize_answer.h"

namespace stiefel::server {
void Linearize(ServerCall& call, const v1::LinearizeRequest& request,
               grpc::ServerWriter<v1::LinearizeResponse>& writer) {
  move_vectors<LinearizeAnswer>(call, request, writer);
}

}  // namespace stiefel::server
