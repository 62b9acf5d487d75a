#include "client/cpp/scene_arrays.h"

#include <utility>

namespace stiefel::client {

Fields scene_arrays(const Connection& connection, const std::string& session_id,
                    Recreation& handle) {
  v1::StreamRequest request;  // for the sample at step 0, before which the arrays come
  request.set_session_id(session_id);
  request.set_scene_arrays(true);
  const Deadline deadline(connection.options.timeout);
  auto recoveries = connection.patience_to_recover(deadline);
  for (auto waiting = connection.patience(deadline);;) {
    grpc::ClientContext context;
    deadline.limit(context);
    handle.route(context);
    const CancelOnStop cancel(connection.options.stop, context);
    const auto reader = connection.stub->Stream(&context, request);
    Assembly arrays;
    v1::StreamResponse message;
    bool complete = false, answered = false;
    while (!complete && reader->Read(&message)) {
      if (!std::exchange(answered, true)) handle.check_build(context, false);
      arrays.take(message.mutable_scene_arrays());
      complete = message.steps_size() > 0;
    }
    if (complete) {
      context.TryCancel();
      reader->Finish();
      return arrays.finish();
    }
    const grpc::Status status = finish(context, *reader);
    if (status.ok()) throw CorruptReply("the arrays of the scene end early");
    handle.check_build(context, true);
    if (waiting.allows_another(status)) continue;
    const Error error = connection.error(status);
    if (!handle.recovers(error, deadline, recoveries)) throw error;
  }
}

}  // namespace stiefel::client
