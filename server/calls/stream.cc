#include <atomic>
#include <limits>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

#include "proto/checksum/checksum.h"
#include "server/admission/admission.h"
#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/calls/stopped.h"
#include "server/calls/wire_bytes.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/stream_messages.h"
#include "server/sessions/field_bytes.h"
#include "server/pricing/memory_price.h"
#include "server/pricing/reading_price.h"
#include "server/scheduling/departure.h"
#include "server/sessions/sampling.h"

namespace stiefel::server {
namespace {

/// Fills a batch on the pool while the messages of the batch before are written. Rests until the
/// reader has taken the message in flight if the next batch is full or the batch before has more
/// messages; computes a large sample only at its turn. Deletes itself.
///
/// A stream whose reader does not read holds one message, as bytes, and a state that it shares with
/// the other streams of the session that rest at that step.
///
/// While the job is queued or runs, only the job touches the call; while it rests, only OnWriteDone
/// does.
class StreamCall final : public grpc::ServerWriteReactor<grpc::ByteBuffer>, private Job {
 public:
  StreamCall(Host& host, CallLog log, SessionLease session, std::vector<std::size_t> fields,
             Sampling::Range range, const v1::StreamRequest& request, MemoryLease memory)
      : host_(host),
        log_(std::move(log)),
        session_(std::move(session)),
        fields_(std::move(fields)),
        range_(range),
        checksum_(request.checksum()),
        sends_scene_(request.scene_arrays()),
        large_(sample_bytes(**session_, fields_) > 2 * Sampling::batch_bytes),
        memory_(std::move(memory)),
        pool_(host.pool_for(kind_with(**session_, sample_work(**session_, fields_)))),
        shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
    const std::int64_t start = (*session_)->start_for(range.from);
    const double price = sampling_work(**session_, fields_, range, start);
    log_.price(price);
    log_.begin();
    const grpc::Status admitted = admit(ticket_, log_.account(), Ticket::Kind::stream, price);
    host_.lifecycle.enter();
    if (!admitted.ok()) {
      end(admitted);
    } else {
      if (log_.tell_price()) StartSendInitialMetadata();
      Job::bill(log_.account().share(), expected_sampling_work(**session_, fields_, range, start));
      pool_.submit(this);
    }
  }

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override {
    if (departure_.is_last()) remove();
  }

 private:
  /// Deletes the call.
  void remove() {
    Host& host = host_;
    delete this;
    host.lifecycle.leave();
  }
  bool run_slice() noexcept override;
  /// Makes the sampling, or sets the error. Returns false if the caller left and OnCancel has
  /// answered.
  bool make_sampling() noexcept;
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
  void end(const grpc::Status& status);

  Host& host_;
  CallLog log_;
  Ticket ticket_;
  Departure departure_;
  std::optional<SessionLease> session_;
  const std::vector<std::size_t> fields_;
  const Sampling::Range range_;
  const bool checksum_, sends_scene_;
  const bool large_;  ///< a sample alone fills two batches
  MemoryLease memory_;
  Pool& pool_;
  std::optional<Sampling> sampling_;
  Batch batch_;                 // being filled
  StreamMessages messages_;     // of the batch before, to be written
  v1::StreamResponse message_;  // to be written next
  grpc::ByteBuffer bytes_;      // being written
  bool priced_ = false;
  bool finite_ = true;  // what was sent
  std::optional<grpc::Status> error_;
  std::atomic<bool> cancelled_ = false;
  std::stop_source stop_;
  std::stop_callback<RequestStop> shutdown_;

  std::mutex mutex_;
  bool writing_ = false;  // guarded by mutex_
  bool resting_ = false;  // guarded by mutex_
};

bool StreamCall::run_slice() noexcept {
  if (!sampling_ && !cancelled_ && !make_sampling()) return false;
  try {
    const bool more = !error_ && work();
    // Other calls or the reader are next; a waiting simulation of large N would hold its memory.
    if (sampling_ && !error_ && (more || still_writing())) sampling_->rest();
    if (more) {
      log_.worked();
      return true;
    }
  } catch (...) {
    error_ = status_of_exception(host_.lifecycle);
  }
  log_.worked();
  {
    const std::lock_guard lock(mutex_);
    resting_ = writing_;
    if (resting_) return false;
  }
  return send();
}

bool StreamCall::make_sampling() noexcept {
  const auto make = [&] {
    if (sends_scene_) messages_.add_scene((*session_)->scene().description());
    sampling_.emplace(**session_, fields_, range_, stop_.get_token());
    sampling_->clear(batch_);
  };
  if (departure_.make(make, [&] { error_ = status_of_exception(host_.lifecycle); })) return true;
  sampling_.reset();
  session_.reset();
  ticket_.give_back();
  if (departure_.is_last()) remove();
  return false;
}

void StreamCall::OnCancel() {
  cancelled_ = true;
  stop_.request_stop();
  if (!departure_.answer_now()) return host_.scheduler.hasten(this);
  log_.finish(errors::cancelled());
  Finish(errors::cancelled());
}

bool StreamCall::work() {
  if (cancelled_) {
    error_ = errors::cancelled();
    return false;
  }
  if (!messages_.empty()) return false;  // the arrays of the scene are sent first
  if (fill()) return true;
  if (cancelled_) error_ = errors::cancelled();
  // If the batch is not full and the writer is busy, as with slow scenes, goes on filling.
  return still_writing() && !sampling_->done() && !sampling_->full(batch_) &&
         !sampling_->price_reached();
}

bool StreamCall::fill() {
  if (host_.lifecycle.stopping()) {
    sampling_->cancel(batch_);
  } else {
    sampling_->fill(batch_, stop_.get_token());
  }
  return batch_.size() == 0 && !sampling_->full(batch_) && !sampling_->done();
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
    resting_ = more;
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
    check_at_the_door(finite_, message_.mutable_run_status());
  }
  if (checksum_) message_.set_checksum(wire::checksum(message_));
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
    if (!ok) cancelled_ = true;
    if (!std::exchange(resting_, false)) return;
  }
  if (cancelled_ && !error_) error_ = errors::cancelled();
  const bool is_next = !error_ && messages_.empty() && batch_.size() == 0;
  if (is_next || send()) pool_.submit(this);
}

void StreamCall::end(const grpc::Status& status) {
  log_.finish(status, sampling_ ? sampling_->cursor().computed_steps() : 0);
  sampling_.reset();
  session_.reset();
  if (status.ok()) {
    StartWriteAndFinish(&bytes_, grpc::WriteOptions(), status);
  } else {
    Finish(status);
  }
}

}  // namespace

grpc::ServerWriteReactor<grpc::ByteBuffer>* Service::Stream(Context* context,
                                                            const v1::StreamRequest* request) {
  CallLog log = open(context, "Stream", request->session_id());
  const auto refuse = [&](const grpc::Status& status) {
    return new RefusedStream<grpc::ByteBuffer>(log, status);
  };
  try {
    auto session = find_session(host_, *context, request->session_id());
    if (!session) return refuse(session.error());
    if (const auto status = check_range(*request); !status.ok()) return refuse(status);
    auto fields = select_fields(**session, request->fields());
    if (!fields) return refuse(errors::invalid(fields.error()));
    const Sampling::Range range{request->from(), request->to(),
                                std::max<std::int64_t>(request->every(), 1),
                                request->checkpoint_every(), request->return_checkpoint()};
    MemoryLease memory(log.account().memory(),
                       stream_memory(**session, *fields, range.checkpoints()) +
                           (request->scene_arrays() ? (*session)->scene_bytes() : 0));
    return new StreamCall(host_, std::move(log), *std::move(session), *std::move(fields), range,
                          *request, std::move(memory));
  } catch (...) {
    return refuse(errors::from_current_exception());
  }
}

}  // namespace stiefel::server
