#pragma once

#include <algorithm>
#include <cstdint>
#include <expected>
#include <optional>
#include <stop_token>
#include <utility>

#include "server/calls/call.h"
#include "server/sessions/cursor.h"

namespace stiefel::server {

/// What a slice of work achieved: no message yet, a message with more to follow, or the last
/// message.
enum class Progress : std::uint8_t { no_message, message, last_message };

/// A call that answers with a stream of messages, computed in slices. Computes nothing while a
/// message is being written. Gives its work and its permit back before it sends the last message.
template <class Response>
class SlicedStream : public Call<grpc::ServerWriteReactor<Response>> {
  using Base = Call<grpc::ServerWriteReactor<Response>>;

 public:
  void OnWriteDone(bool ok) override {
    log_.written();
    if (!ok) this->caller_left();
    host_.scheduler.submit(this, kind_);
  }

 protected:
  using Base::cancelled, Base::end, Base::host_, Base::log_, Base::stop;

  SlicedStream(Host& host, CallLog log, JobKind kind) : Base(host, std::move(log)), kind_(kind) {}

  /// Whether `make` is to run before the next slice.
  virtual bool makes_next() const { return false; }
  /// Makes a last checkpoint, if the call has any, for a server that stops. Returns whether there
  /// is anything to send before the call ends.
  virtual bool save() { return false; }
  /// Runs one slice and continues `message` as the previous slice left it. An error ends the call.
  virtual std::expected<Progress, grpc::Status> slice(Response& message) = 0;

  const JobKind kind_;

 private:
  bool run_slice() noexcept override {
    if (makes_next() && !cancelled() && !this->make_now()) return false;
    try {
      const auto progress = checked_slice();
      if (!progress || *progress == Progress::last_message) {
        end(progress ? grpc::Status::OK : progress.error());
        return false;
      }
      log_.worked();
      if (*progress == Progress::no_message) return true;
      log_.writing();
      this->StartWrite(&message_);
    } catch (...) {
      end(errors::from_current_exception());
    }
    return false;
  }

  std::expected<Progress, grpc::Status> checked_slice() {
    if (!std::exchange(started_, true) && host_.lifecycle.refusing())
      return std::unexpected(errors::shutting_down());
    if (cancelled()) return std::unexpected(errors::cancelled());
    if (host_.lifecycle.stopping() && !save()) return std::unexpected(errors::shutting_down());
    const auto progress = slice(message_);
    if (cancelled()) return std::unexpected(errors::cancelled());
    return progress;
  }

  void answer(const grpc::Status& status) override {
    if (status.ok())
      this->StartWriteAndFinish(&message_, grpc::WriteOptions(), status);
    else
      this->Finish(status);
  }

  bool started_ = false;
  Response message_;
};

/// A call in which each slice makes one message by `Produce`.
template <class Response, class Produce>
class ProducedStream final : public SlicedStream<Response> {
 public:
  ProducedStream(Host& host, CallLog log, JobKind kind, double price, Produce produce)
      : SlicedStream<Response>(host, std::move(log), kind), produce_(std::move(produce)) {
    this->begin(kind, Permit::Kind::call, price, price, true);
  }

 private:
  std::expected<Progress, grpc::Status> slice(Response& message) override {
    const std::stop_token stop = this->stop();
    const auto last = stoppable(stop, [&] { return (*produce_)(stop, message); });
    if (!last) return std::unexpected(errors::cancelled());
    if (!*last) return std::unexpected(last->error());
    return **last ? Progress::last_message : Progress::message;
  }
  void free() noexcept override { produce_.reset(); }

  std::optional<Produce> produce_;
};

/// Starts a call in which each slice makes one message: `produce(stop, message)` returns
/// expected<bool, grpc::Status>, true for the last message. The token also stops what `produce`
/// computes in the engine. `price` is the most instructions that all messages take; at least the
/// kind's `price_cap` is billed.
template <class Response, class Produce>
grpc::ServerWriteReactor<Response>* message_a_slice(Host& host, CallLog log, JobKind kind,
                                                    double price, Produce produce) {
  return new ProducedStream<Response, Produce>(
      host, std::move(log), kind, std::max(price, price_cap(kind)), std::move(produce));
}

}  // namespace stiefel::server
