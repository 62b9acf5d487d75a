#include "server/calls/moved_vectors.h"
#include "server/convert/tangents/lyapunov_answer.h"

namespace stiefel::server {
void LyapunovSpectrum(ServerCall& call, const v1::LyapunovSpectrumRequest& request,
                      grpc::ServerWriter<v1::LyapunovSpectrumResponse>& writer) {
  move_vectors<LyapunovAnswer>(call, request, writer);
}

}  // namespace stiefel::server
