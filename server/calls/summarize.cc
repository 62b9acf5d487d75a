#include <algorithm>
#include <chrono>
#include <utility>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/errors.h"
#include "server/convert/summarize_answer.h"
#include "server/convert/work_price.h"

namespace stiefel::server {
namespace {

/// The longest time without a message.
constexpr std::chrono::milliseconds longest_silence{500};

}  // namespace

void Summarize(ServerCall& call, const v1::SummarizeRequest& request,
               grpc::ServerWriter<v1::SummarizeResponse>& writer) {
  SessionLease session = call.session(request.session_id());
  check(check_range(request));
  const ReadingWork reading = reading_work(*session, request);
  const double step_cost =
      session->step_cost() + reading.each / instructions_a_nanosecond /
                                 static_cast<double>(std::max<std::int64_t>(request.every(), 1));
  SummarizeAnswer answer(std::move(session), request, reading.total);
  check(answer.read(call.account().memory()));
  check(answer.make());
  check(answer.start());
  send_results<v1::SummarizeResponse>(call, writer, answer, longest_silence, [&] {
    if (answer.price_reached()) throw StatusError(errors::price_reached(*answer.price_reached()));
    answer.advance(slice_fraction(step_cost), call.stop());
    if (answer.interrupted()) throw Stopped();  // a reading may be incomplete
    answer.collect();
  });
  call.log().did(0, answer.computed_steps());
}

}  // namespace stiefel::server
