#include <memory>
#include <optional>
#include <utility>

#include "server/calls/call.h"
#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/step.h"
#include "server/sessions/field_bytes.h"

namespace stiefel::server {
namespace {

/// Reads requests one by one and answers each before it reads the next. Holds no lease between
/// requests, so that a silent call does not keep its session from expiring.
class DriveCall final
    : public Call<grpc::ServerBidiReactor<ReadRequest<v1::DriveRequest>, v1::DriveResponse>> {
 public:
  DriveCall(Host& host, const grpc::CallbackServerContext& context, CallLog log)
      : Call(host, std::move(log)), context_(context) {
    memory_ = MemoryLease(log_.account().memory(), 0);  // of the largest reply, which is kept
    const grpc::Status admitted = admit(permit_, log_.account(), Permit::Kind::stream, 0);
    admitted.ok() ? StartRead(&request_) : end(admitted);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return end(cancelled() ? errors::cancelled() : status_after_last_read());
    if (request_.size() <= inline_request) return take_request();
    const double work = work_of_a_byte * static_cast<double>(request_.size());
    Job::bill(log_.account().share(), work);
    takes_request_ = true;
    submit(kind_of_piece(work));
  }
  void OnWriteDone(bool ok) override {
    log_.written();
    pause();
    ok ? StartRead(&request_) : end(errors::cancelled());
  }

 private:
  /// Reads a request and answers it here, or queues the call.
  void take_request();
  grpc::Status prepare(const v1::DriveRequest& request);
  /// Takes a permit for a request that is not answered here.
  grpc::Status admit_request();
  void submit(JobKind kind) {
    run();
    host_.scheduler.submit(this, kind);
  }
  bool run_slice() noexcept override;
  grpc::Status make() override {
    cursor_.emplace(**session_, task_.to, stop());
    return grpc::Status::OK;
  }
  void free() noexcept override {
    cursor_.reset();
    session_.reset();
    request_permit_.give_back();
  }
  std::int64_t computed_steps() const override { return steps_; }
  void fail(const grpc::Status& status) override { reply(status); }

  /// Empties the response and keeps the memory of its step.
  void clear() {
    if (response_.has_step()) {
      response_.mutable_step()->Clear();
    } else {
      response_.Clear();
    }
  }
  void reply(const grpc::Status& status) {
    free();
    if (status.ok()) {
      steps_ += response_.step().computed_steps();
    } else {
      const grpc::Status error = told(status);
      log_.refuse(error);
      errors::to_proto(error, response_.mutable_error());
    }
    log_.writing();
    StartWrite(&response_);
  }
  /// Returns the status of a call without further requests.
  grpc::Status status_after_last_read() const {
    if (read_) return grpc::Status::OK;
    return errors::invalid("request", "absent", "the first message must name a session");
  }

  const grpc::CallbackServerContext& context_;
  Permit request_permit_;
  ReadRequest<v1::DriveRequest> request_;
  v1::DriveResponse response_;
  std::string id_;  // of the session that the first valid request named
  std::weak_ptr<Session> known_;
  std::optional<SessionLease> session_;  // held while a request is answered
  StepTask task_;
  std::optional<Cursor> cursor_;
  std::int64_t steps_ = 0;
  bool read_ = false;           // a request was read
  bool takes_request_ = false;  // a worker is to read the request
};

void DriveCall::take_request() {
  const bool first = !std::exchange(read_, true);
  try {
    clear();
    if (!request_.read(log_.account().memory()))
      return end(errors::invalid("request", "its bytes are not a DriveRequest",
                                 first ? "the first message must name a session" : "must be one"));
    const auto status = prepare(request_.message());
    request_.drop();
    if (!status.ok()) return reply(status);
    if (step_inline(**session_, task_, log_.account(), response_.mutable_step())) {
      log_.did(response_.step().price().work());
      return reply(grpc::Status::OK);
    }
    if (const auto admitted = admit_request(); !admitted.ok()) return reply(admitted);
  } catch (...) {
    return reply(errors::from_current_exception());
  }
  submit((*session_)->step_kind().kind);
}

/// Checks the request and sets the task from it.
grpc::Status DriveCall::prepare(const v1::DriveRequest& request) {
  if (host_.lifecycle.refusing()) return errors::shutting_down();
  const std::string& id = request.session_id();
  if (!id_.empty() && !id.empty() && id != id_) {
    return errors::invalid("session_id", id, "must be empty or '" + id_ + "'");
  }
  if (auto known = known_.lock()) session_.emplace(std::move(known));
  if (!session_ || (*session_)->closed()) {
    auto found = find_session(host_, context_, id_.empty() ? id : id_);
    if (!found) return found.error();
    session_.emplace(*std::move(found));
    known_ = session_->session();
    if (std::exchange(id_, (*session_)->id()).empty()) {
      log_.name(id_);
      log_.begin();
    }
    task_.fields = *select_fields(**session_, {});
  }
  if (const auto status = check_step("to", request.to()); !status.ok()) return status;
  if (request.fields_size() > 0) {
    auto fields = select_fields(**session_, request.fields());
    if (!fields) return errors::invalid(fields.error());
    task_.fields = *std::move(fields);
  }
  task_.to = request.to();
  task_.return_checkpoint = request.return_checkpoint();
  if (const auto status = check_size(**session_, task_); !status.ok()) return status;
  memory_.grow_to(step_memory(**session_, task_));
  return grpc::Status::OK;
}

grpc::Status DriveCall::admit_request() {
  const Session& session = **session_;
  const std::int64_t start = session.start_for(task_.to);
  const double price = session.most_work(start, task_.to);
  const auto admitted = admit(request_permit_, log_.account(), Permit::Kind::call, price);
  log_.price(price);
  if (admitted.ok()) Job::bill(log_.account().share(), session.work(start, task_.to));
  return admitted;
}

bool DriveCall::run_slice() noexcept {
  if (!takes_request_ && !cursor_ && !cancelled() && !make_now()) return false;
  try {
    if (cancelled()) {
      reply(errors::cancelled());
      return false;
    }
    if (std::exchange(takes_request_, false)) {
      take_request();
      return false;
    }
    std::int64_t budget = slice_steps((*session_)->step_cost());
    if (host_.lifecycle.stopping()) {
      if (cursor_->step() < task_.to) cursor_->cancel();
    } else if (!cursor_->advance(task_.to, budget, stop())) {
      log_.worked();
      return true;
    }
    const bool stopped = cursor_->stopped();
    if (!stopped) answer_step(**session_, *cursor_, task_, response_.mutable_step());
    log_.worked();
    reply(stopped ? errors::shutting_down(**session_, cursor_->simulation()) : grpc::Status::OK);
  } catch (...) {
    reply(errors::from_current_exception());
  }
  return false;
}

}  // namespace

Begun<grpc::ServerBidiReactor<ReadRequest<v1::DriveRequest>, v1::DriveResponse>> Service::Drive(
    Context& context, CallLog& log) {
  return new DriveCall(host_, context, std::move(log));
}

}  // namespace stiefel::server
