#include <atomic>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>

#include "server/admission/admission.h"
#include "server/calls/cursor_call.h"
#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/step.h"
#include "server/calls/stopped.h"
#include "server/convert/errors.h"
#include "server/scheduling/departure.h"
#include "server/scheduling/failpoint.h"
#include "server/sessions/field_bytes.h"

namespace stiefel::server {
namespace {

/// Reads requests one by one and answers each before it reads the next. Holds no lease between
/// requests, so that a silent call does not keep its session from expiring. Deletes itself.
class DriveCall final
    : public grpc::ServerBidiReactor<ReadRequest<v1::DriveRequest>, v1::DriveResponse>,
      private Job {
 public:
  DriveCall(Host& host, const grpc::CallbackServerContext& context, CallLog log)
      : host_(host),
        context_(context),
        log_(std::move(log)),
        memory_(log_.account().memory(), 0),
        shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
    const grpc::Status admitted = admit(ticket_, log_.account(), Ticket::Kind::stream, 0);
    admitted.ok() ? StartRead(&request_) : end(admitted);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return end(cancelled_ ? errors::cancelled() : status_after_last_read());
    if (request_.size() <= inline_request) return begin();
    const double work = work_of_a_byte * static_cast<double>(request_.size());
    Job::bill(log_.account().share(), work);
    begins_ = true;
    submit_to(host_.pool_for_piece(work));
  }
  void OnWriteDone(bool ok) override {
    log_.written();
    if (std::exchange(running_, false)) host_.lifecycle.leave();
    ok ? StartRead(&request_) : end(errors::cancelled());
  }
  void OnCancel() override {
    cancelled_ = true;
    stop_.request_stop();
    if (!departure_.answer_now()) return host_.scheduler.hasten(this);
    log_.finish(errors::cancelled(), steps_);
    Finish(errors::cancelled());
  }
  void OnDone() override {
    if (departure_.is_last()) remove();
  }

 private:
  /// Reads and answers a request, or lets the pool answer it.
  void begin();
  void submit_to(Pool& pool) {
    if (!std::exchange(running_, true)) host_.lifecycle.enter();
    pool.submit(this);
  }
  grpc::Status prepare(const v1::DriveRequest& request);
  /// Takes a place in the account for a request that is not answered inline.
  grpc::Status enter();
  bool run_slice() noexcept override;
  /// Makes the cursor. Returns false if the request is answered: with an error, or because the
  /// caller left and OnCancel has answered.
  bool make_cursor() noexcept;
  /// Deletes the call.
  void remove() {
    Host& host = host_;
    const bool running = running_;
    delete this;
    if (running) host.lifecycle.leave();
  }

  /// Empties the response and keeps the memory of its step.
  void clear() {
    if (response_.has_step()) {
      response_.mutable_step()->Clear();
    } else {
      response_.Clear();
    }
  }
  void reply(const grpc::Status& status) {
    lease_.reset();
    request_ticket_.give_back();
    if (status.ok()) {
      steps_ += response_.step().computed_steps();
    } else {
      log_.refuse(status);
      errors::to_proto(status, response_.mutable_error());
    }
    log_.writing();
    StartWrite(&response_);
  }
  void reply_from_pool(const grpc::Status& status) {
    cursor_.reset();
    reply(status);
  }
  /// Returns the status of a call without further requests.
  grpc::Status status_after_last_read() const {
    if (read_) return grpc::Status::OK;
    return errors::invalid("request", "absent", "the first message must name a session");
  }
  void end(const grpc::Status& status) {
    log_.finish(status, steps_);
    lease_.reset();
    Finish(status);
  }

  Host& host_;
  const grpc::CallbackServerContext& context_;
  CallLog log_;
  Ticket ticket_, request_ticket_;
  MemoryLease memory_;  // of the largest reply so far, whose memory is kept
  ReadRequest<v1::DriveRequest> request_;
  v1::DriveResponse response_;
  std::string id_;  // of the session that the first valid request named
  std::weak_ptr<Session> session_;
  std::optional<SessionLease> lease_;  // held while a request is answered
  StepTask task_;
  std::optional<Cursor> cursor_;
  Departure departure_;
  std::int64_t steps_ = 0;
  bool read_ = false;     // a request was read
  bool begins_ = false;   // a worker is to read the request
  bool running_ = false;  // counted by the lifecycle
  std::atomic<bool> cancelled_ = false;
  std::stop_source stop_;
  std::stop_callback<RequestStop> shutdown_;
};

void DriveCall::begin() {
  const bool first = !std::exchange(read_, true);
  try {
    clear();
    if (!request_.read(log_.account().memory()))
      return end(errors::invalid("request", "its bytes are not a DriveRequest",
                                 first ? "the first message must name a session" : "must be one"));
    const auto status = prepare(request_.message());
    request_.drop();
    if (!status.ok()) return reply(status);
    if (step_inline(**lease_, task_, log_.account(), response_.mutable_step())) {
      log_.did(response_.step().price().work());
      return reply(grpc::Status::OK);
    }
    if (const auto entered = enter(); !entered.ok()) return reply(entered);
  } catch (...) {
    return reply(errors::from_current_exception());
  }
  submit_to(host_.pool_for((*lease_)->step_kind()));
}

/// Checks the request and sets the task from it.
grpc::Status DriveCall::prepare(const v1::DriveRequest& request) {
  failpoint("drive.prepare");
  if (host_.lifecycle.refusing()) return errors::shutting_down();
  const std::string& id = request.session_id();
  if (!id_.empty() && !id.empty() && id != id_) {
    return errors::invalid("session_id", id, "must be empty or '" + id_ + "'");
  }
  if (auto known = session_.lock()) lease_.emplace(std::move(known));
  if (!lease_ || (*lease_)->closed()) {
    auto found = find_session(host_, context_, id_.empty() ? id : id_);
    if (!found) return found.error();
    lease_.emplace(*std::move(found));
    session_ = lease_->session();
    if (std::exchange(id_, (*lease_)->id()).empty()) {
      log_.name(id_);
      log_.begin();
    }
    task_.fields = *select_fields(**lease_, {});
  }
  if (const auto status = check_step("to", request.to()); !status.ok()) return status;
  if (request.fields_size() > 0) {
    auto fields = select_fields(**lease_, request.fields());
    if (!fields) return errors::invalid(fields.error());
    task_.fields = *std::move(fields);
  }
  task_.to = request.to();
  task_.return_checkpoint = request.return_checkpoint();
  if (const auto status = check_size(**lease_, task_); !status.ok()) return status;
  if (const auto refusal = log_.account().overdrawn()) return errors::over_quota(*refusal);
  memory_.grow_to(step_memory(**lease_, task_));
  return grpc::Status::OK;
}

grpc::Status DriveCall::enter() {
  failpoint("drive.enter");
  const Session& session = **lease_;
  const std::int64_t start = session.start_for(task_.to);
  const double price = session.most_work(start, task_.to);
  const auto admitted = admit(request_ticket_, log_.account(), Ticket::Kind::call, price);
  log_.price(price);
  if (admitted.ok()) Job::bill(log_.account().share(), session.work(start, task_.to));
  return admitted;
}

bool DriveCall::make_cursor() noexcept {
  std::optional<grpc::Status> failure;
  if (!departure_.make([&] { cursor_.emplace(**lease_, task_.to, stop_.get_token()); },
                       [&] { failure = status_of_exception(host_.lifecycle); })) {
    cursor_.reset();
    lease_.reset();
    request_ticket_.give_back();
    if (departure_.is_last()) remove();
    return false;
  }
  if (failure) reply_from_pool(*failure);
  return !failure;
}

bool DriveCall::run_slice() noexcept {
  if (std::exchange(begins_, false) && !cancelled_) {
    begin();
    return false;
  }
  if (!cursor_ && !cancelled_ && !make_cursor()) return false;
  try {
    if (cancelled_) {
      reply_from_pool(errors::cancelled());
      return false;
    }
    std::int64_t budget = slice_steps((*lease_)->step_cost());
    if (host_.lifecycle.stopping()) {
      if (cursor_->step() < task_.to) cursor_->cancel();
    } else if (!cursor_->advance(task_.to, budget, stop_.get_token())) {
      log_.worked();
      return true;
    }
    answer_step(**lease_, *cursor_, task_, response_.mutable_step());
    log_.worked();
    reply_from_pool(grpc::Status::OK);
  } catch (...) {
    reply_from_pool(status_of_exception(host_.lifecycle));
  }
  return false;
}

}  // namespace

grpc::ServerBidiReactor<ReadRequest<v1::DriveRequest>, v1::DriveResponse>* Service::Drive(
    Context* context) {
  return new DriveCall(host_, *context, open(context, "Drive"));
}

}  // namespace stiefel::server
