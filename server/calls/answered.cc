#include "server/calls/answered.h"

#include "server/convert/errors.h"

namespace stiefel::server {
namespace {

grpc::Status status_of(const WriteFault& fault) noexcept {
  try {
    return errors::not_written(fault);
  } catch (...) {
    return errors::out_of_memory();
  }
}

}  // namespace

void when_written(const Answered& answered, const std::function<void(const grpc::Status&)>& send) {
  if (!answered.pending_write) return send(answered.status);
  try {
    answered.pending_write->then([send, status = answered.status](const auto& fault) {
      fault ? send(status_of(*fault)) : send(status);
    });
  } catch (...) {
    send(errors::from_current_exception());
  }
}

WrittenCall::WrittenCall(Host& host, CallLog log, const Answered& answered, MemoryLease memory)
    : host_(host), log_(std::move(log)), memory_(std::move(memory)) {
  host_.lifecycle.enter();
  when_written(answered, [this](const grpc::Status& status) {
    log_.finish(status);
    Finish(status);
  });
}

void WrittenCall::OnDone() {
  Host& host = host_;
  delete this;
  host.lifecycle.leave();
}

}  // namespace stiefel::server
