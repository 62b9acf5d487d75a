#pragma once

#include <grpcpp/support/server_callback.h>

#include <expected>
#include <functional>
#include <stop_token>
#include <utility>

#include "server/admission/admission.h"
#include "server/calls/host.h"
#include "server/calls/stopped.h"
#include "server/convert/errors.h"
#include "server/limits/failpoint.h"
#include "server/sessions/stoppable.h"

namespace stiefel::server {

/// A call with a stream of answers that is refused. Deletes itself.
template <class Message>
class RefusedStream final : public grpc::ServerWriteReactor<Message> {
 public:
  RefusedStream(CallLog& log, const grpc::Status& status) {
    log.finish(status);
    this->Finish(status);
  }
  void OnDone() override { delete this; }
};

/// A call that answers with a stream of messages, each the work of one slice on a pool.
/// While a message is written nothing is computed. Deletes itself.
template <class Response>
class SlicedStream final : public grpc::ServerWriteReactor<Response>, private Job {
 public:
  /// Writes the next message; true for the last one. The token asks to stop when the caller cancels
  /// or the server goes down.
  using Produce =
      std::function<std::expected<bool, grpc::Status>(const std::stop_token&, Response&)>;

  SlicedStream(Host& host, Pool& pool, CallLog log, Produce produce)
      : host_(host),
        pool_(pool),
        log_(std::move(log)),
        produce_(std::move(produce)),
        shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
    log_.price(pool.price_cap());
    log_.begin();
    const grpc::Status admitted =
        admit(ticket_, log_.account(), Ticket::Kind::call, pool.price_cap());
    host_.lifecycle.enter();
    if (!admitted.ok()) {
      log_.finish(admitted);
      this->Finish(admitted);
    } else {
      Job::bill(log_.account().share(), pool.price_cap());
      pool_.submit(this);
    }
  }

  void OnCancel() override { stop_.request_stop(); }
  void OnWriteDone(bool ok) override {
    log_.written();
    if (!ok) stop_.request_stop();
    pool_.submit(this);
  }
  void OnDone() override {
    Host& host = host_;
    delete this;
    host.lifecycle.leave();
  }

 private:
  bool run_slice() noexcept override {
    std::expected<bool, grpc::Status> last = false;
    try {
      if (host_.lifecycle.refusing() && !std::exchange(started_, true))
        last = std::unexpected(errors::shutting_down());
      else
        last = produce();
      started_ = true;
      if (stop_.stop_requested() && !host_.lifecycle.stopping())
        last = std::unexpected(errors::cancelled());
    } catch (...) {
      last = std::unexpected(errors::from_current_exception());
    }
    if (last && !*last) {
      log_.worked();
      log_.writing();
      this->StartWrite(&message_);
      return false;
    }
    log_.finish(last ? grpc::Status::OK : last.error());
    if (last)
      this->StartWriteAndFinish(&message_, grpc::WriteOptions(), grpc::Status::OK);
    else
      this->Finish(last.error());
    return false;
  }

  std::expected<bool, grpc::Status> produce() {
    failpoint("call.produce");
    const std::stop_token stop = stop_.get_token();
    const auto last = stoppable(stop, [&] { return produce_(stop, message_); });
    return last ? *last : std::unexpected(stopped(host_.lifecycle));
  }

  Host& host_;
  Pool& pool_;
  CallLog log_;
  Ticket ticket_;
  const Produce produce_;
  std::stop_source stop_;
  std::stop_callback<RequestStop> shutdown_;
  bool started_ = false;
  Response message_;
};

}  // namespace stiefel::server
