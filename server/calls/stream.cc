#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include "server/calls/call.h"
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

/// Fills a batch while gRPC writes the messages of the batch before. Waits for the reader once the
/// batch is full, or while the batch before has more messages. A sample that fills two batches
/// alone is computed when the one before was written.
///
/// A stream that waits holds one message, as bytes, a full batch, and a state, of which it shares
/// the copy with other streams of the session that wait at that step.
///
/// While the job is queued or runs, only the job uses the call; while it waits, only OnWriteDone
/// does.
class StreamCall final : public Call<grpc::ServerWriteReactor<grpc::ByteBuffer>> {
 public:
  StreamCall(Host& host, CallLog log, SessionLease session, std::vector<std::size_t> fields,
             Sampling::Range range, const v1::StreamRequest& request, MemoryLease memory)
      : Call(host, std::move(log), std::move(memory)),
        session_(std::move(session)),
        fields_(std::move(fields)),
        range_(range),
        sends_scene_(request.scene_arrays()),
        large_(sample_bytes(**session_, fields_) > 2 * Sampling::batch_bytes),
        kind_(kind_with(**session_, sample_work(**session_, fields_))) {
    const std::int64_t start = (*session_)->start_for(range.from);
    begin(kind_, Permit::Kind::stream, sampling_work(**session_, fields_, range, start),
          expected_sampling_work(**session_, fields_, range, start));
  }

  void OnWriteDone(bool ok) override;

 private:
  bool run_slice() noexcept override;
  /// Runs one slice; returns true to be called again, false when there is a message to send.
  bool work();
  /// Fills the batch for one slice; returns true to be called again, false when there is a batch to
  /// send.
  bool fill();
  bool still_writing() {
    const std::lock_guard lock(mutex_);
    return writing_;
  }
  /// Sends the next message or ends the call; returns true when there is more to fill.
  bool send() noexcept;
  void write_next();

  grpc::Status make() override;
  void free() noexcept override {
    sampling_.reset();
    session_.reset();
  }
  std::int64_t computed_steps() const override {
    return sampling_ ? sampling_->cursor().computed_steps() : 0;
  }
  void answer(const grpc::Status& status) override {
    if (status.ok())
      StartWriteAndFinish(&bytes_, grpc::WriteOptions(), status);
    else
      Finish(status);
  }

  std::optional<SessionLease> session_;
  const std::vector<std::size_t> fields_;
  const Sampling::Range range_;
  const bool sends_scene_;
  const bool large_;  ///< a sample alone fills two batches
  const JobKind kind_;
  std::optional<Sampling> sampling_;
  Batch batch_;                 // being filled
  StreamMessages messages_;     // of the batch before, to be written
  v1::StreamResponse message_;  // to be written next
  grpc::ByteBuffer bytes_;      // being written
  bool priced_ = false;
  bool finite_ = true;  // what was sent
  std::optional<grpc::Status> error_;

  std::mutex mutex_;
  bool writing_ = false;  // guarded by mutex_
  bool waiting_ = false;  // guarded by mutex_
};

grpc::Status StreamCall::make() {
  if (sends_scene_) messages_.add_scene((*session_)->scene().description());
  sampling_.emplace(**session_, fields_, range_, stop());
  sampling_->clear(batch_);
  return grpc::Status::OK;
}

bool StreamCall::run_slice() noexcept {
  if (!sampling_ && !cancelled() && !make_now()) return false;
  try {
    const bool more = !error_ && work();
    // Other calls or the reader are next; a waiting simulation of large N would hold its memory.
    if (sampling_ && !error_ && (more || still_writing())) sampling_->rest();
    if (more) {
      log_.worked();
      return true;
    }
  } catch (...) {
    error_ = errors::from_current_exception();
  }
  log_.worked();
  {
    const std::lock_guard lock(mutex_);
    waiting_ = writing_;
    if (waiting_) return false;
  }
  return send();
}

bool StreamCall::work() {
  if (cancelled()) {
    error_ = errors::cancelled();
    return false;
  }
  if (!messages_.empty()) return false;  // the arrays of the scene are sent first
  if (fill()) return true;
  if (cancelled()) error_ = errors::cancelled();
  // If the batch is not full and the writer is busy, as with slow scenes, goes on filling.
  return still_writing() && !sampling_->done() && !sampling_->full(batch_) &&
         !sampling_->price_reached();
}

bool StreamCall::fill() {
  if (!host_.lifecycle.stopping() || sampling_->done())
    sampling_->fill(batch_, stop());
  else if (!sampling_->save(batch_))
    error_ = errors::shutting_down();
  return !error_ && batch_.size() == 0 && !sampling_->full(batch_) && !sampling_->done();
}

bool StreamCall::send() noexcept {
  try {
    if (!error_) write_next();
  } catch (...) {
    error_ = errors::from_current_exception();
  }
  if (error_) {
    end(*error_);
    return false;
  }
  bool more = !messages_.empty();
  if (!more && sampling_->done()) {
    end(grpc::Status::OK);
    return false;
  }
  more = more || large_;
  {
    const std::lock_guard lock(mutex_);
    writing_ = true;
    waiting_ = more;
  }
  log_.writing();
  StartWrite(&bytes_);
  return !more;
}

/// Takes the next message of the batch before, or packs the filled batch once all of it is sent.
void StreamCall::write_next() {
  const bool packs = messages_.empty();
  if (packs) {
    sampling_->trim(batch_);
    messages_.pack(**session_, fields_, batch_, sampling_->take_checkpoint(), message_);
  } else {
    messages_.next(message_);
  }
  sampling_->rest();
  const Cursor& cursor = sampling_->cursor();
  message_.set_computed_steps(cursor.computed_steps());
  if (!std::exchange(priced_, true)) {
    to_proto(sampling_->work(), sampling_->bytes(), bound_of_steps(**session_),
             (*session_)->simulation_bytes() + memory_.bytes(), message_.mutable_price());
  }
  finite_ = finite_ && is_finite(message_.fields());
  if (messages_.empty() && sampling_->done()) {
    to_proto(cursor, (*session_)->scene(), message_.mutable_run_status());
    demand_finite(finite_, message_.mutable_run_status());
  }
  serialize(message_, bytes_);
  if (packs) {
    if (!large_) messages_.unpack(message_, batch_);
    sampling_->clear(batch_);
  }
  if (large_) message_ = {};  // gives its memory back
}

void StreamCall::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    log_.written();
    if (!ok) caller_left();
    if (!std::exchange(waiting_, false)) return;
  }
  if (cancelled() && !error_) error_ = errors::cancelled();
  const bool is_next = !error_ && messages_.empty() && batch_.size() == 0;
  if (is_next || send()) host_.scheduler.submit(this, kind_);
}

}  // namespace

Begun<grpc::ServerWriteReactor<grpc::ByteBuffer>> Service::Stream(
    Context& context, CallLog& log, const v1::StreamRequest& request) {
  auto session = find_session(host_, context, request.session_id());
  if (!session) return session.error();
  if (auto status = check_range(request); !status.ok()) return status;
  auto fields = select_fields(**session, request.fields());
  if (!fields) return errors::invalid(fields.error());
  const Sampling::Range range{request.from(), request.to(),
                              std::max<std::int64_t>(request.every(), 1),
                              request.checkpoint_every(), request.return_checkpoint()};
  MemoryLease memory(log.account().memory(),
                     stream_memory(**session, *fields, range, request.scene_arrays()));
  return new StreamCall(host_, std::move(log), *std::move(session), *std::move(fields), range,
                        request, std::move(memory));
}

}  // namespace stiefel::server
