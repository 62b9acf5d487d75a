#include "server/calls/moved_vectors.h"
#include "server/convert/tangents/lyapunov_answer.h"

namespace stiefel::server {
void LyapunovSpectrum(ServerCall& call, const v1::LyapunovSpectrumRequest& request,
                      Writer& writer) {
  move_vectors<LyapunovAnswer, v1::LyapunovSpectrumResponse>(call, request, writer);
}

}  // namespace stiefel::server
