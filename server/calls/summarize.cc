#include <chrono>
#include <utility>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/errors.h"
#include "server/convert/summarize_answer.h"

namespace stiefel::server {
void Summarize(ServerCall& call, const v1::SummarizeRequest& request, Writer& writer) {
  constexpr std::chrono::milliseconds longest_silence{500};
  SessionRef session = call.session(request.session_id());
  check_range(request);
  const double slice = slice_fraction(session->step_cost());
  call.hold(0);
  SummarizeAnswer answer(std::move(session), request, call.memory());
  send_results<v1::SummarizeResponse>(call, writer, answer, longest_silence, slice,
                                      [&](double steps) { answer.advance(steps, call.stop()); });
  call.log().did(0, answer.computed_steps());
}

}  // namespace stiefel::server
