#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "client/cpp/late.h"
#include "client/cpp/replies.h"
#include "stiefel/client/recreation.h"

namespace stiefel::client {

/// Makes a call whose replies end with a run status, and makes it again where the server or the
/// session was lost, until it ends; returns its last reply. `call(context)` starts the call of a
/// session to step `to`. `reading` takes the replies:
///   begin()                   prepares for the replies of a new stream
///   take(reply)               returns false when the receiver ends the call
///   last()                    the last reply, with a run status once it has come
///   has_progressed()          whether a new stream can begin later than this one did
///   begins_anew_after(error)  changes the request so that the refused call can be made again
template <class Reading, class Call>
auto whole_reply(const Connection& connection, Recreation& recreation,
                 const std::string& session_id, std::int64_t to, Reading& reading,
                 const Call& call) {
  const Deadline deadline(connection.options.compute_timeout);
  auto waiting = connection.patience(deadline);
  auto recoveries = connection.patience_to_recover(deadline);
  while (true) {
    reading.begin();
    grpc::ClientContext context;
    deadline.limit(context);
    recreation.route(context);
    const CancelOnStop cancel(connection.options.stop, context);
    const auto reader = call(context);
    std::remove_cvref_t<decltype(reading.last())> message;
    bool wanted = true, answered = false;
    while (wanted && reader->Read(&message)) {
      if (!std::exchange(answered, true)) recreation.check_build(context, false);
      wanted = reading.take(message);
    }
    if (!wanted) {
      context.TryCancel();
      reader->Finish();
      return std::move(reading.last());
    }
    const grpc::Status status = finish(context, *reader);
    if (status.ok()) {
      require(reading.last().has_run_status(), "the call ends without saying how the run ended");
      return std::move(reading.last());
    }
    recreation.check_build(context, true);
    const Error error = connection.error(status, context);
    if (reading.has_progressed()) {
      waiting = connection.patience(deadline);
      recoveries = connection.patience_to_recover(deadline);
    }
    if (reading.begins_anew_after(error)) continue;
    if (!waiting.allows_another(status) && !recreation.recovers(error, deadline, recoveries))
      throw with_standing(error, connection, session_id, to);
  }
}

}  // namespace stiefel::client
