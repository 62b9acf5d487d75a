#include <algorithm>
#include <chrono>
#include <utility>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/memory_price.h"
#include "server/convert/messages.h"
#include "server/convert/work_price.h"
#include "server/sessions/field_bytes.h"
#include "server/sessions/sampling.h"

namespace stiefel::server {
namespace {

/// Returns the most bytes of a stream of the fields, with or without checkpoints: those of one that
/// nobody reads. The state at which it waits is priced by its session.
std::uint64_t stream_memory(const Session& session, const std::vector<std::size_t>& fields,
                            const Sampling::Range& range, bool sends_scene) {
  const std::uint64_t sample = sample_bytes(session, fields);
  const std::uint64_t batch = std::max<std::uint64_t>(Sampling::batch_bytes, sample);
  // A sample that needs several messages is held beside them.
  return memory_price({.workspace = (sample > max_reply_bytes ? sample : 0) +
                                    (range.checkpoints() ? 2 * checkpoint_bytes(session) : 0) +
                                    (sends_scene ? session.scene_bytes() : 0),
                       .reply = std::min<std::uint64_t>(batch, max_reply_bytes)});
}

/// The longest time for which a sample waits for others to fill a message.
constexpr std::chrono::milliseconds longest_wait{10};

/// Takes samples until the batch is full, all are taken or one has waited for `longest_wait`.
void fill(ServerCall& call, Sampling& sampling, Batch& batch) {
  const auto end = std::chrono::steady_clock::now() + longest_wait;
  while (true) {
    sampling.fill(batch, call.stop());
    if (sampling.cursor().stopped()) throw Stopped();
    if (sampling.done() || sampling.full(batch) || sampling.price_reached()) return;
    if (batch.size() > 0 && std::chrono::steady_clock::now() > end) return;
    call.pass();
  }
}

/// What a stream sends: the messages of one batch after the other.
class Sent {
 public:
  Sent(ServerCall& call, const Session& session, const std::vector<std::size_t>& fields,
       Sampling& sampling, grpc::ServerWriter<grpc::ByteBuffer>& writer)
      : call_(call), session_(session), fields_(fields), sampling_(sampling), writer_(writer) {
    sampling_.clear(batch_);
  }

  Batch& batch() { return batch_; }
  /// Sends the arrays of the scene.
  void scene() {
    messages_.add_scene(session_.scene().description());
    rest();
  }
  /// Sends the batch and empties it.
  void send() {
    sampling_.trim(batch_);
    messages_.pack(session_, fields_, batch_, sampling_.take_checkpoint(), message_);
    complete();
    StreamMessages::unpack(message_, batch_);
    sampling_.clear(batch_);
    write();
    rest();
  }

 private:
  void rest() {
    while (!messages_.empty()) {
      messages_.next(message_);
      complete();
      write();
    }
  }
  /// Sends the bytes. A simulation of large N would hold its memory while the reader lets it wait.
  void write() {
    const bool last = messages_.empty() && sampling_.done();
    if (!last) sampling_.rest();
    call_.write(writer_, bytes_, last);
  }
  /// Adds what a message has beside its samples, and serializes it.
  void complete() {
    message_.set_computed_steps(sampling_.cursor().computed_steps());
    if (std::exchange(first_, false))
      to_proto(sampling_.work(), sampling_.bytes(), bound_of_steps(session_),
               session_.simulation_bytes() + call_.memory().bytes(), message_.mutable_price());
    finite_ = finite_ && is_finite(message_.fields());
    if (messages_.empty() && sampling_.done()) {
      to_proto(sampling_.cursor(), session_.scene(), message_.mutable_run_status());
      demand_finite(finite_, message_.mutable_run_status());
    }
    serialize(message_, bytes_);
  }

  ServerCall& call_;
  const Session& session_;
  const std::vector<std::size_t>& fields_;
  Sampling& sampling_;
  grpc::ServerWriter<grpc::ByteBuffer>& writer_;
  Batch batch_;
  StreamMessages messages_;
  v1::StreamResponse message_;
  grpc::ByteBuffer bytes_;
  bool first_ = true, finite_ = true;
};

}  // namespace

void Stream(ServerCall& call, const v1::StreamRequest& request,
            grpc::ServerWriter<grpc::ByteBuffer>& writer) {
  const SessionLease session = call.session(request.session_id());
  check(check_range(request));
  const auto fields = value_of(select_fields(*session, request.fields()));
  const Sampling::Range range{request.from(), request.to(),
                              std::max<std::int64_t>(request.every(), 1),
                              request.checkpoint_every(), request.return_checkpoint()};
  call.hold(stream_memory(*session, fields, range, request.scene_arrays()));
  Sampling sampling(*session, fields, range, call.stop());
  Sent sent(call, *session, fields, sampling, writer);
  if (request.scene_arrays()) sent.scene();
  try {
    while (!sampling.done()) {
      fill(call, sampling, sent.batch());
      sent.send();
    }
  } catch (const Stopped&) {
    if (!call.caller_left() && sampling.save(sent.batch())) sent.send();
    throw;
  }
}

}  // namespace stiefel::server
