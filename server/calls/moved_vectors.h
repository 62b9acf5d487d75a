#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "server/convert/tangents/linearize_answer.h"

namespace stiefel::server {

/// Answers a call that moves tangent vectors along the states of a session: `Answer` is
/// LinearizeAnswer, whose messages all have results, or LyapunovAnswer.
template <class Answer, class Response, class Request>
void move_vectors(ServerCall& call, const Request& request, Writer& writer) {
  constexpr bool reports = !std::is_same_v<Answer, LinearizeAnswer>;
  constexpr auto longest_silence = reports ? std::chrono::milliseconds(100) : until_results;
  SessionRef session = call.session(request.session_id());
  check_range(request);
  if (const auto members = session->scene().members().size(); members > 0)
    throw errors::invalid("session_id", std::to_string(members) + " members",
                          "the scene must have no `members`");
  call.hold(memory_price({held_by(request), tangent_workspace(*session, request)}));
  const double slice = slice_fraction(session->step_cost());
  Answer answer(std::move(session), request);
  send_results<Response>(call, writer, answer, longest_silence, slice, [&](double steps) {
    answer.advance(std::max<std::int64_t>(static_cast<std::int64_t>(steps), 1), call.stop());
  });
  call.log().did(0, answer.computed_steps());
}

}  // namespace stiefel::server
