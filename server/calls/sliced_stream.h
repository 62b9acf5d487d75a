#pragma once

#include <grpcpp/support/server_callback.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <expected>
#include <memory>
#include <stop_token>
#include <utility>

#include "server/admission/admission.h"
#include "server/calls/host.h"
#include "server/calls/stopped.h"
#include "server/convert/errors.h"
#include "server/scheduling/departure.h"
#include "server/scheduling/failpoint.h"
#include "server/sessions/cursor.h"

namespace stiefel::server {

/// Refuses a call that would answer with a stream: ends it with an error. Deletes itself.
template <class Message>
class RefusedStream final : public grpc::ServerWriteReactor<Message> {
 public:
  RefusedStream(CallLog& log, const grpc::Status& status) {
    log.finish(status);
    this->Finish(status);
  }
  void OnDone() override { delete this; }
};

/// What a slice of work achieved: no message yet, a message with more to follow, or the last
/// message.
enum class Progress : std::uint8_t { no_message, message, last_message };

/// The computation of a call that answers with a stream of messages.
template <class Response>
class StreamWork {
 public:
  virtual ~StreamWork() = default;
  /// Whether `make` is to run before the next slice.
  virtual bool makes_next() const { return false; }
  /// Makes a simulation. When the caller cancels, gRPC may delete the request while this runs, so
  /// the request must not be used. An error ends the call.
  virtual grpc::Status make(const std::stop_token&) { return grpc::Status::OK; }
  /// Runs one slice and continues `message` as the previous slice left it. The token requests a
  /// stop when the caller cancels or the server shuts down. An error ends the call.
  virtual std::expected<Progress, grpc::Status> slice(const std::stop_token& stop,
                                                      Response& message) = 0;
  /// The steps computed so far, for the call's line in the log.
  virtual std::int64_t computed_steps() const { return 0; }
};

/// A call that answers with a stream of messages, computed in slices on a pool. Computes nothing
/// while a message is being written. Gives the work and the call's place in its account back before
/// it sends the last message; when the caller has cancelled, after its answer. Deletes itself.
template <class Response>
class SlicedStream final : public grpc::ServerWriteReactor<Response>, private Job {
 public:
  using Work = std::unique_ptr<StreamWork<Response>>;

  /// `price`: the most instructions of all slices. `expected`: those that are billed.
  SlicedStream(Host& host, Pool& pool, CallLog log, Ticket::Kind kind, double price,
               double expected, Work work)
      : host_(host),
        pool_(pool),
        log_(std::move(log)),
        work_(std::move(work)),
        shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
    log_.price(price);
    log_.begin();
    const grpc::Status admitted = admit(ticket_, log_.account(), kind, price);
    host_.lifecycle.enter();
    if (!admitted.ok()) {
      end(admitted);
    } else {
      if (log_.tell_price()) this->StartSendInitialMetadata();
      Job::bill(log_.account().share(), expected);
      pool_.submit(this);
    }
  }

  void OnCancel() override {
    leave();
    if (!departure_.answer_now()) return host_.scheduler.hasten(this);
    log_.finish(errors::cancelled());
    this->Finish(errors::cancelled());
  }
  void OnWriteDone(bool ok) override {
    log_.written();
    if (!ok) leave();
    pool_.submit(this);
  }
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
  bool run_slice() noexcept override {
    if (work_->makes_next() && !cancelled_ && !make()) return false;
    const auto progress = slice();
    if (!progress || *progress == Progress::last_message) {
      end(progress ? grpc::Status::OK : progress.error());
      return false;
    }
    log_.worked();
    if (*progress == Progress::no_message) return true;
    log_.writing();
    this->StartWrite(&message_);
    return false;
  }

  /// Returns false if the call has ended: with an error, or because its caller left and OnCancel
  /// has answered.
  bool make() noexcept {
    grpc::Status made;
    if (!departure_.make([&] { made = work_->make(stop_.get_token()); },
                         [&] { made = errors::from_current_exception(); })) {
      free();
      return false;
    }
    if (!made.ok()) end(cancelled_ ? errors::cancelled() : made);
    return made.ok();
  }

  std::expected<Progress, grpc::Status> slice() {
    try {
      failpoint("call.slice");
      if (!std::exchange(started_, true) && host_.lifecycle.refusing())
        return std::unexpected(errors::shutting_down());
      if (cancelled_) return std::unexpected(errors::cancelled());
      const auto progress = work_->slice(stop_.get_token(), message_);
      if (cancelled_) return std::unexpected(errors::cancelled());
      return progress;
    } catch (...) {
      return std::unexpected(errors::from_current_exception());
    }
  }
  void leave() {
    cancelled_ = true;
    stop_.request_stop();
  }

  void end(const grpc::Status& status) {
    log_.finish(status, work_->computed_steps());
    if (cancelled_ && !status.ok()) {
      departure_.answer_first();
      this->Finish(status);
      return free();
    }
    work_.reset();
    ticket_.give_back();
    if (status.ok())
      this->StartWriteAndFinish(&message_, grpc::WriteOptions(), status);
    else
      this->Finish(status);
  }

  /// Frees what the call holds after its answer.
  void free() {
    work_.reset();
    ticket_.give_back();
    if (departure_.is_last()) remove();
  }

  Host& host_;
  Pool& pool_;
  CallLog log_;
  Ticket ticket_;
  Departure departure_;
  Work work_;
  std::atomic<bool> cancelled_ = false;
  std::stop_source stop_;
  std::stop_callback<RequestStop> shutdown_;
  bool started_ = false;
  Response message_;
};

/// Starts a call in which each slice makes one message: `produce(stop, message)` returns
/// expected<bool, grpc::Status>, true for the last message. The token also stops what `produce`
/// computes in the engine. `price` is the most instructions that all messages take; at least the
/// pool's cap is billed.
template <class Response, class Produce>
grpc::ServerWriteReactor<Response>* message_a_slice(Host& host, Pool& pool, CallLog log,
                                                    double price, Produce produce) {
  class Work final : public StreamWork<Response> {
   public:
    Work(const Lifecycle& lifecycle, Produce produce)
        : lifecycle_(lifecycle), produce_(std::move(produce)) {}
    std::expected<Progress, grpc::Status> slice(const std::stop_token& stop,
                                                Response& message) override {
      const auto last = stoppable(stop, [&] { return produce_(stop, message); });
      if (!last) return std::unexpected(stopped(lifecycle_));
      if (!*last) return std::unexpected(last->error());
      return **last ? Progress::last_message : Progress::message;
    }

   private:
    const Lifecycle& lifecycle_;
    Produce produce_;
  };
  price = std::max(price, pool.price_cap());
  return new SlicedStream<Response>(host, pool, std::move(log), Ticket::Kind::call, price, price,
                                    std::make_unique<Work>(host.lifecycle, std::move(produce)));
}

}  // namespace stiefel::server
