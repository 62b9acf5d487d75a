#include <atomic>
#include <limits>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/requests.h"
#include "server/sessions/sampling.h"

namespace stiefel::server {
namespace {

/// Fills one message on the pool while the one before is written. With one in flight and one full
/// it rests until the reader has taken the first. Deletes itself.
///
/// While the job is queued or runs, only the job touches the call; while it rests, only
/// OnWriteDone.
class StreamCall final : public grpc::ServerWriteReactor<v1::StreamResponse>, private Job {
 public:
  StreamCall(Host& host, CallLog log, SessionLease session, std::vector<std::size_t> fields,
             Sampling::Range range)
      : host_(host),
        log_(std::move(log)),
        session_(std::move(session)),
        fields_(std::move(fields)),
        range_(range),
        pool_(host.pool_for((*session_)->step_cost())),
        shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
    host_.lifecycle.enter();
    pool_.submit(this);
  }

  void OnWriteDone(bool ok) override;
  void OnCancel() override {
    cancelled_ = true;
    stop_.request_stop();
  }
  void OnDone() override {
    Host& host = host_;
    delete this;
    host.lifecycle.leave();
  }

 private:
  bool run_slice() noexcept override;
  /// False when there is a message to be sent or an error to end with, true to be called again.
  bool fill();
  /// True when the writer is busy and a slow scene has not filled a message: go on meanwhile.
  bool goes_on();
  bool waits();
  bool still_writing() {
    const std::lock_guard lock(mutex_);
    return writing_;
  }
  /// Sends what is filled, or ends. True when there is more to fill.
  bool send() noexcept;
  void pack(v1::StreamResponse& message);
  void end(const grpc::Status& status);

  Host& host_;
  CallLog log_;
  std::optional<SessionLease> session_;
  const std::vector<std::size_t> fields_;
  const Sampling::Range range_;
  Pool& pool_;
  std::optional<Sampling> sampling_;
  Batch batch_;                 // being filled
  v1::StreamResponse message_;  // being written
  std::optional<grpc::Status> error_;
  std::atomic<bool> cancelled_ = false;
  std::stop_source stop_;
  std::stop_callback<RequestStop> shutdown_;

  std::mutex mutex_;
  bool writing_ = false;  // guarded by mutex_
  bool resting_ = false;  // guarded by mutex_
};

bool StreamCall::run_slice() noexcept {
  try {
    if (cancelled_) {
      error_ = errors::cancelled();
    } else if (fill() || goes_on()) {
      return true;
    } else if (still_writing()) {
      sampling_->rest();
    }
  } catch (...) {
    error_ = errors::from_current_exception();
  }
  return waits() ? false : send();
}

bool StreamCall::goes_on() {
  return still_writing() && !sampling_->done() && !sampling_->full(batch_);
}

/// True when there is a message before this one that nobody has taken yet.
bool StreamCall::waits() {
  const std::lock_guard lock(mutex_);
  return resting_ = writing_;
}

bool StreamCall::fill() {
  if (!sampling_) {
    sampling_.emplace(**session_, fields_, range_);
    sampling_->clear(batch_);
  }
  if (host_.lifecycle.stopping()) {
    sampling_->cancel(batch_);
  } else {
    sampling_->fill(batch_, stop_.get_token());
  }
  return batch_.size() == 0 && !sampling_->done();
}

bool StreamCall::send() noexcept {
  try {
    if (!error_) pack(message_);
  } catch (...) {
    error_ = errors::from_current_exception();
  }
  if (error_ || sampling_->done()) {
    end(error_ ? *error_ : grpc::Status::OK);
    return false;
  }
  {
    const std::lock_guard lock(mutex_);
    writing_ = true;
  }
  StartWrite(&message_);
  return true;
}

/// Moves the batch into the message, and the message's memory into the batch; the last message
/// says how the run ended.
void StreamCall::pack(v1::StreamResponse& message) {
  sampling_->trim(batch_);
  message.mutable_steps()->Assign(batch_.steps.begin(), batch_.steps.end());
  message.mutable_times()->Assign(batch_.times.begin(), batch_.times.end());
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const int index = static_cast<int>(i);
    auto* field =
        index < message.fields_size() ? message.mutable_fields(index) : message.add_fields();
    describe_field((*session_)->fields()[fields_[i]], batch_.size(), field);
    field->mutable_value()->mutable_data()->swap(batch_.fields[i]);
  }
  sampling_->clear(batch_);
  const Cursor& cursor = sampling_->cursor();
  message.set_computed_steps(cursor.computed_steps());
  if (sampling_->done()) to_proto(cursor, (*session_)->scene(), message.mutable_run_status());
}

void StreamCall::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    if (!ok) cancelled_ = true;
    if (!std::exchange(resting_, false)) return;
  }
  if (cancelled_ && !error_) error_ = errors::cancelled();
  if (send()) pool_.submit(this);
}

void StreamCall::end(const grpc::Status& status) {
  log_.finish(status, sampling_ ? sampling_->cursor().computed_steps() : 0);
  sampling_.reset();
  session_.reset();
  if (status.ok()) {
    StartWriteAndFinish(&message_, grpc::WriteOptions(), status);
  } else {
    Finish(status);
  }
}

/// A call that is refused.
class RefusedStream final : public grpc::ServerWriteReactor<v1::StreamResponse> {
 public:
  explicit RefusedStream(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

grpc::Status check_range(const v1::StreamRequest& request) {
  if (const auto status = check_step("from", request.from()); !status.ok()) return status;
  if (const auto status = check_step("to", request.to(), request.from()); !status.ok())
    return status;
  if (request.every() >= 0) return grpc::Status::OK;
  return errors::invalid("every", std::to_string(request.every()), "must be at least 0");
}

}  // namespace

grpc::ServerWriteReactor<v1::StreamResponse>* Service::Stream(Context* context,
                                                              const v1::StreamRequest* request) {
  CallLog log(host_.log, *context, "Stream", request->session_id());
  const auto refuse =
      [&](const grpc::Status& status) -> grpc::ServerWriteReactor<v1::StreamResponse>* {
    log.finish(status);
    return new RefusedStream(status);
  };
  try {
    auto session = find_session(host_, request->session_id());
    if (!session) return refuse(session.error());
    if (const auto status = check_range(*request); !status.ok()) return refuse(status);
    auto fields = select_fields(**session, request->fields());
    if (!fields) return refuse(errors::invalid(fields.error()));
    return new StreamCall(
        host_, std::move(log), *std::move(session), *std::move(fields),
        {request->from(), request->to(), std::max<std::int64_t>(request->every(), 1)});
  } catch (...) {
    return refuse(errors::from_current_exception());
  }
}

}  // namespace stiefel::server
