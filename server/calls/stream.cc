#include <algorithm>
#include <chrono>
#include <semaphore>
#include <utility>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/memory_price.h"
#include "server/convert/messages.h"
#include "server/scheduling/memory_limit.h"
#include "server/sessions/field_bytes.h"
#include "server/sessions/sampling.h"

namespace stiefel::server {
namespace {

/// Returns the most bytes of a stream of the fields, with or without checkpoints: those of one that
/// nobody reads. The state at which it waits is priced by its session.
std::uint64_t stream_memory(const Session& session, const std::vector<std::size_t>& fields,
                            const Sampling::Range& range) {
  return memory_price(
      {.workspace = range.checkpoints() ? 2 * checkpoint_bytes(session) : 0,
       .reply = std::max<std::uint64_t>(Sampling::batch_bytes, sample_bytes(session, fields))});
}

/// The longest time for which a sample waits for others to fill a message.
constexpr std::chrono::milliseconds longest_wait{10};

/// A stream's place among those that hold a large simulation at once: the others of the principal
/// wait without one. A small simulation needs no place.
class LargePlace {
 public:
  LargePlace(ServerCall& call, const Session& session)
      : call_(call), places_(call.account().large_streams()), needed_(Cursor::is_large(session)) {
    take();
  }
  ~LargePlace() { leave(); }
  LargePlace(const LargePlace&) = delete;
  LargePlace& operator=(const LargePlace&) = delete;

  void take() {
    if (!needed_ || taken_) return;
    while (!(taken_ = call_.without_place([&] { return places_.try_acquire_for(longest_look); })))
      call_.pass();
  }
  /// Gives the place back, and the simulation unless it is between two states or its state does not
  /// fit into the memory. Returns whether it gave the simulation back.
  bool rest(Sampling& sampling) {
    if (!needed_) return false;
    const bool rests = sampling.suspend();
    leave();
    give_back_unused_stack();
    return rests;
  }
  void leave() {
    if (std::exchange(taken_, false)) places_.release();
  }

 private:
  static constexpr std::chrono::milliseconds longest_look{50};

  ServerCall& call_;
  std::counting_semaphore<>& places_;
  const bool needed_;
  bool taken_ = false;
};

/// Takes samples until the batch is full, all are taken or one has waited for `longest_wait`.
void fill(ServerCall& call, LargePlace& place, Sampling& sampling, Batch& batch) {
  using Clock = std::chrono::steady_clock;
  for (auto end = Clock::now() + longest_wait;; call.pass()) {
    place.take();
    sampling.fill(batch, call.stop());
    if (sampling.cursor().stopped()) throw Stopped();
    if (sampling.done() || sampling.full(batch)) return;
    if (Clock::now() < end) continue;
    if (batch.size() > 0) return;
    place.rest(sampling);
    end = Clock::now() + longest_wait;
  }
}

/// What a stream sends: a message for each batch.
class Sent {
 public:
  Sent(ServerCall& call, const Session& session, const std::vector<std::size_t>& fields,
       LargePlace& place, Sampling& sampling, grpc::ServerWriter<grpc::ByteBuffer>& writer)
      : call_(call),
        session_(session),
        fields_(fields),
        place_(place),
        sampling_(sampling),
        writer_(writer) {
    sampling_.clear(batch_);
  }

  Batch& batch() { return batch_; }
  /// Sends the batch and empties it. A large simulation and its batch are not held while the reader
  /// lets it wait.
  void send() {
    sampling_.trim(batch_);
    pack(session_, fields_, batch_, sampling_.take_checkpoint(), message_);
    message_.set_computed_steps(sampling_.cursor().computed_steps());
    message_.set_work(call_.work());
    finite_ = finite_ && is_finite(message_.fields());
    if (sampling_.done()) {
      to_proto(sampling_.cursor(), session_.scene(), message_.mutable_run_status());
      demand_finite(finite_, message_.mutable_run_status());
    }
    serialize(message_, bytes_);
    unpack(message_, batch_);
    sampling_.clear(batch_);
    if (sampling_.done()) {
      place_.leave();
    } else if (place_.rest(sampling_)) {
      batch_ = {};
      sampling_.clear(batch_);
    }
    call_.write(writer_, bytes_, sampling_.done());
  }

 private:
  ServerCall& call_;
  const Session& session_;
  const std::vector<std::size_t>& fields_;
  LargePlace& place_;
  Sampling& sampling_;
  grpc::ServerWriter<grpc::ByteBuffer>& writer_;
  Batch batch_;
  v1::StreamResponse message_;
  grpc::ByteBuffer bytes_;
  bool finite_ = true;
};

}  // namespace

void Stream(ServerCall& call, const v1::StreamRequest& request,
            grpc::ServerWriter<grpc::ByteBuffer>& writer) {
  const SessionRef session = call.session(request.session_id());
  check_range(request);
  const auto fields = select_fields(*session, request.fields());
  const Sampling::Range range{request.from(), request.to(),
                              std::max<std::int64_t>(request.every(), 1),
                              request.checkpoint_every(), request.return_checkpoint()};
  call.hold(stream_memory(*session, fields, range));
  LargePlace place(call, *session);
  Sampling sampling(*session, fields, range);
  Sent sent(call, *session, fields, place, sampling, writer);
  try {
    while (!sampling.done()) {
      fill(call, place, sampling, sent.batch());
      sent.send();
    }
  } catch (const Stopped&) {
    if (!call.caller_left() && sampling.save(sent.batch())) sent.send();
    throw;
  }
}

}  // namespace stiefel::server
