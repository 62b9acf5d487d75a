#pragma once

#include <algorithm>
#include <cstdint>
#include <expected>
#include <memory>
#include <stop_token>
#include <utility>

#include "server/calls/call.h"
#include "server/scheduling/failpoint.h"
#include "server/sessions/cursor.h"

namespace stiefel::server {

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

/// A call that answers with a stream of messages, computed in slices. Computes nothing while a
/// message is being written. Gives the work and its permit back before it sends the last message.
template <class Response>
class SlicedStream final : public Call<grpc::ServerWriteReactor<Response>> {
  using Base = Call<grpc::ServerWriteReactor<Response>>;
  using Base::cancelled, Base::end, Base::host_, Base::log_, Base::stop;

 public:
  using Work = std::unique_ptr<StreamWork<Response>>;

  /// `price`: the most instructions of all slices. `expected`: those that are billed.
  SlicedStream(Host& host, CallLog log, JobKind kind, Permit::Kind permit, double price,
               double expected, Work work)
      : Base(host, std::move(log)), kind_(kind), work_(std::move(work)) {
    this->begin(kind, permit, price, expected);
  }

  void OnWriteDone(bool ok) override {
    log_.written();
    if (!ok) this->caller_left();
    host_.scheduler.submit(this, kind_);
  }

 private:
  bool run_slice() noexcept override {
    if (work_->makes_next() && !cancelled() && !this->make_now()) return false;
    try {
      const auto progress = slice();
      if (!progress || *progress == Progress::last_message) {
        end(progress ? grpc::Status::OK : progress.error());
        return false;
      }
      log_.worked();
      if (*progress == Progress::no_message) return true;
      log_.writing();
      this->StartWrite(&message_);
    } catch (...) {
      end(status_of_exception(host_.lifecycle));
    }
    return false;
  }

  std::expected<Progress, grpc::Status> slice() {
    failpoint("call.slice");
    if (!std::exchange(started_, true) && host_.lifecycle.refusing())
      return std::unexpected(errors::shutting_down());
    if (cancelled()) return std::unexpected(errors::cancelled());
    const auto progress = work_->slice(stop(), message_);
    if (cancelled()) return std::unexpected(errors::cancelled());
    return progress;
  }

  grpc::Status make() override { return work_->make(stop()); }
  void free() noexcept override { work_.reset(); }
  std::int64_t computed_steps() const override { return work_ ? work_->computed_steps() : 0; }
  void answer(const grpc::Status& status) override {
    if (status.ok())
      this->StartWriteAndFinish(&message_, grpc::WriteOptions(), status);
    else
      this->Finish(status);
  }

  const JobKind kind_;
  Work work_;
  bool started_ = false;
  Response message_;
};

/// Starts a call in which each slice makes one message: `produce(stop, message)` returns
/// expected<bool, grpc::Status>, true for the last message. The token also stops what `produce`
/// computes in the engine. `price` is the most instructions that all messages take; at least the
/// kind's `price_cap` is billed.
template <class Response, class Produce>
grpc::ServerWriteReactor<Response>* message_a_slice(Host& host, CallLog log, JobKind kind,
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
  price = std::max(price, price_cap(kind));
  return new SlicedStream<Response>(host, std::move(log), kind, Permit::Kind::call, price, price,
                                    std::make_unique<Work>(host.lifecycle, std::move(produce)));
}

}  // namespace stiefel::server
