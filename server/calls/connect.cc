#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>
#include <utility>

#include "server/calls/service.h"
#include "server/convert/geodesics/geodesic_answers.h"
#include "server/convert/memory_price.h"
#include "server/convert/work_price.h"
#include "server/sessions/cursor.h"

namespace stiefel::server {
namespace {

/// Joins pairs of frames, and sends the answer of a pair as soon as the message before is written,
/// while other pairs are joined. A slice ends when a long job waits and the slice has lasted 0.2 s,
/// or when the answers that wait for the reader have no more room. Threads that have joined their
/// last pair of a slice wait for the others, so that shorter slices would take more time.
class ConnectCall final : public Call<grpc::ServerWriteReactor<v1::ConnectResponse>> {
 public:
  /// `memory`: of the request; that of the searches is taken once the request is read.
  ConnectCall(Host& host, CallLog log, const v1::ConnectRequest& request, MemoryLease memory)
      : Call(host, std::move(log), std::move(memory)), request_(request) {
    const double price = std::max(connect_work(request), price_cap(kind));
    begin(kind, Permit::Kind::call, price, price, true);
  }

  void OnWriteDone(bool ok) override;

 private:
  static constexpr JobKind kind = JobKind::unsliced;

  bool run_slice() noexcept override;
  void free() noexcept override {
    answer_.reset();
    memory_ = {};
  }
  void answer(const grpc::Status& status) override {
    if (status.ok())
      StartWriteAndFinish(&message_, grpc::WriteOptions(), status);
    else
      Finish(status);
  }

  /// Joins pairs until the slice ends.
  grpc::Status work();
  /// Sends the next message, unless one is being written or the next is the last one.
  void send();
  /// Takes the next message, under the lock; returns whether it is to be written at once.
  bool take_message();

  const v1::ConnectRequest& request_;
  std::optional<ConnectAnswer> answer_;  // emplaced before the first message

  std::mutex mutex_;
  // Guarded by mutex_; message_ belongs to gRPC while it is being written.
  v1::ConnectResponse message_;
  bool writing_ = false;
  bool has_last_ = false;  // message_ is the last one
  bool rests_ = false;     // OnWriteDone submits the job
  grpc::Status error_;
};

bool ConnectCall::run_slice() noexcept {
  grpc::Status status;
  try {
    if (!answer_ && host_.lifecycle.refusing()) status = errors::shutting_down();
    if (cancelled()) status = errors::cancelled();
    if (status.ok())
      status = stoppable(stop(), [this] { return work(); }).value_or(errors::cancelled());
  } catch (...) {
    status = errors::from_current_exception();
  }
  {
    const std::lock_guard lock(mutex_);
    log_.worked();
    if (error_.ok()) error_ = cancelled() ? errors::cancelled() : status;
    if (error_.ok() && answer_->can_join()) return true;
    rests_ = writing_;
    if (rests_) return false;
    status = error_;
  }
  end(status);
  return false;
}

grpc::Status ConnectCall::work() {
  if (!answer_) {
    auto task = read(request_);
    if (!task) return task.error();
    constexpr std::uint64_t part_of_memory = 8;
    const std::uint64_t workspace = connect_workspace(request_);
    const std::size_t at_once = searches_at_once(request_, workspace, host_.scheduler.threads(),
                                                 log_.account().memory().limit() / part_of_memory);
    memory_.grow_to(memory_.bytes() + at_once * workspace + waiting_answers_bytes(request_));
    answer_.emplace(*std::move(task), memory_.bytes(), at_once);
  }
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::milliseconds(200);
  answer_->join(
      stop(), [&] { return Clock::now() > end && host_.scheduler.long_waits(); },
      [this] { send(); });
  return grpc::Status::OK;
}

void ConnectCall::send() {
  {
    const std::lock_guard lock(mutex_);
    if (!take_message()) return;
  }
  StartWrite(&message_);
}

bool ConnectCall::take_message() {
  if (writing_ || has_last_ || !error_.ok()) return false;
  const auto taken = answer_->next(message_);
  if (!taken) error_ = taken.error();
  if (!taken || !*taken) return false;
  has_last_ = answer_->done();
  if (has_last_) return false;
  log_.writing();
  return writing_ = true;
}

void ConnectCall::OnWriteDone(bool ok) {
  bool writes = false, submits = false;
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    log_.written();
    if (!ok) caller_left();
    try {
      writes = !cancelled() && take_message();
    } catch (...) {
      error_ = errors::from_current_exception();
    }
    if (rests_ && (!writes || answer_->can_join())) {
      rests_ = false;
      submits = true;
    }
  }
  if (writes) StartWrite(&message_);
  if (submits) host_.scheduler.submit(this, kind);
}

}  // namespace

Service::Writing<v1::ConnectResponse> Service::Connect(Context&, CallLog& log,
                                                       const v1::ConnectRequest& request) {
  MemoryLease memory(log.account().memory(), memory_price({.request = held_by(request)}));
  return new ConnectCall(host_, std::move(log), request, std::move(memory));
}

}  // namespace stiefel::server
