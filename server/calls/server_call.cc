#include "server/calls/server_call.h"

#include <grpcpp/impl/codegen/proto_utils.h>

#include <new>

#include "server/calls/requests.h"

namespace stiefel::server {

ServerCall::ServerCall(Host& host, grpc::ServerContext& context, const char* name)
    : host_(host),
      context_(context),
      log_(std::in_place, host.log, context, name, host.metrics.get()) {
  host_.lifecycle.enter();
}

ServerCall::~ServerCall() {
  if (callers_) callers_->leave(context_);
  if (counted_) account_->leave_call(host_.open_calls);
  host_.lifecycle.leave();
}

void ServerCall::admit(Callers* callers) {
  callers_ = callers;
  Principal principal;
  if (callers) {
    const auto admitted = callers->admit(context_);
    if (!admitted)
      throw admitted.error() == Refused::token_missing ? errors::token_missing()
                                                       : errors::token_unknown();
    principal = *admitted;
  }
  account_ = &host_.accounts.of(host_.identify ? host_.identify(context_) : principal);
  log_->bill(*account_);
  turn_.emplace(
      host_.turns, account_->share(), stop_source_, [this] { return context_.IsCancelled(); },
      account_->most_time());
  if (const auto refusal = account_->enter_call(host_.open_calls))
    throw errors::over_quota(*refusal);
  counted_ = true;
}

SessionRef ServerCall::session(std::string_view id, const char* field) {
  return find_session(host_, context_, account_->principal(), id, field);
}

ServerCall::Computed::~Computed() {
  of.turn_->give();
  of.log_->did(of.work());
}

const google::protobuf::Message& ServerCall::read(grpc::ByteBuffer& bytes,
                                                  const google::protobuf::Message& prototype) {
  if (bytes.Length() > short_request) turn_->take();
  if (const auto* message = request_.read(bytes, prototype, account().memory())) return *message;
  throw errors::invalid("request", "", "the bytes are not a " + prototype.GetDescriptor()->name());
}

grpc::ByteBuffer ServerCall::to_bytes(const google::protobuf::Message& message) {
  grpc::ByteBuffer bytes;
  bool own = false;
  if (!grpc::SerializationTraits<google::protobuf::Message>::Serialize(message, &bytes, &own).ok())
    throw std::bad_alloc();
  return bytes;
}

void ServerCall::leave() { throw errors::cancelled(); }

void ServerCall::advance(const Session& session, Cursor& cursor, std::int64_t to) {
  const auto piece = [&] {
    std::int64_t steps = slice_steps(session.step_cost());
    return cursor.advance(to, steps, stop_);
  };
  try {
    while (!piece()) pass();
  } catch (const Stopped&) {
    cursor.cancel();
  }
  log_->did(0, cursor.computed_steps());
  if (!cursor.stopped()) return;
  if (!host_.lifecycle.stopping()) throw Stopped();
  throw errors::shutting_down(session, cursor.simulation());
}

void ServerCall::wait_for(const PendingWrite& change) {
  if (!change.valid()) return;
  const auto fault = turn_->without_place([&] { return change.get(); });
  if (fault) throw errors::not_written(*fault);
}

grpc::Status ServerCall::current_error() const {
  grpc::Status status = errors::from_current_exception();
  // What a stop interrupted may have another error of its own.
  const bool told = status.error_code() == grpc::UNAVAILABLE;
  if (stop_.stop_requested() && !told) status = errors::cancelled();
  if (status.error_code() != grpc::CANCELLED || caller_left()) return status;
  if (turn_ && turn_->time_is_up())
    return errors::time_reached(std::chrono::duration<double>(account_->most_time()).count());
  return host_.lifecycle.stopping() ? errors::shutting_down() : status;
}

void ServerCall::end(const grpc::Status& status) {
  turn_.reset();
  log_->finish(status);
}

}  // namespace stiefel::server
