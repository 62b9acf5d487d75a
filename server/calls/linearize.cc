#include "server/calls/moved_vectors.h"

namespace stiefel::server {
void Linearize(ServerCall& call, const v1::LinearizeRequest& request, Writer& writer) {
  move_vectors<LinearizeAnswer, v1::LinearizeResponse>(call, request, writer);
}

}  // namespace stiefel::server
