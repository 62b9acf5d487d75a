#pragma once

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <cstdint>
#include <stop_token>
#include <type_traits>
#include <utility>

#include "server/calls/host.h"
#include "server/convert/errors.h"

namespace stiefel::server {

/// What a handler returns: the reactor of a call that goes on, or the status of one that has ended.
template <class Reactor>
struct Begun {
  Begun(Reactor* of_call) : reactor(of_call) {}
  Begun(grpc::Status of_call) : status(std::move(of_call)) {}

  Reactor* reactor = nullptr;  ///< null: the call has ended with `status`
  grpc::Status status;
};

/// The stop callback of a call.
struct RequestStop {
  std::stop_source stop;
  void operator()() { stop.request_stop(); }
};

/// Takes a permit for a call with that price, in instructions. Returns RESOURCE_EXHAUSTED with the
/// limit if there is none.
inline grpc::Status admit(Permit& permit, Account& account, Permit::Kind kind, double price) {
  const auto refusal = permit.take(account, kind, price);
  return refusal ? errors::over_quota(*refusal) : grpc::Status::OK;
}

/// What every call consists of that computes on the scheduler's threads: its log and price, its
/// permit, its memory, its stop, and its end. `Reactor` is gRPC's, of one RPC. A derived class
/// computes in `run_slice`. Deletes itself.
///
/// A caller who cancels is answered before what the call holds is freed, because to free the
/// simulation of an ensemble, whole or half made, takes up to 0.1 s: by `OnCancel` while a worker
/// makes the simulation, otherwise by the worker. The later of gRPC and the worker deletes the
/// call.
template <class Reactor>
class Call : public Reactor, protected Job {
 public:
  void OnCancel() override {
    caller_left();
    State expected = State::making;
    if (!state_.compare_exchange_strong(expected, State::answered))
      return host_.scheduler.cancel(this);
    log_.finish(errors::cancelled(), computed_steps());
    this->Finish(errors::cancelled());
  }
  void OnDone() override { remove_if_last(); }

 protected:
  /// `memory` is held until the reply is delivered.
  Call(Host& host, CallLog log, MemoryLease memory = {})
      : host_(host),
        log_(std::move(log)),
        memory_(std::move(memory)),
        shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {}

  /// Takes a permit and queues the call, or ends it if there is none. `price`: the most
  /// instructions that it takes; `expected`: those that are billed; `at_most`: whether it may end
  /// long before it has taken them. Call it last in a constructor.
  void begin(JobKind kind, Permit::Kind permit, double price, double expected,
             bool at_most = false) {
    log_.price(price);
    if constexpr (!std::is_same_v<Reactor, grpc::ServerUnaryReactor>) log_.begin();
    const grpc::Status admitted = admit(permit_, log_.account(), permit, price);
    run();
    if (!admitted.ok()) return end(admitted);
    if (log_.tell_price(at_most)) this->StartSendInitialMetadata();
    Job::bill(log_.account().share(), expected);
    host_.scheduler.submit(this, kind);
  }
  /// Counts the call as running until `pause` or until it is deleted.
  void run() {
    if (!std::exchange(runs_, true)) host_.lifecycle.enter();
  }
  void pause() {
    if (std::exchange(runs_, false)) host_.lifecycle.leave();
  }

  /// Makes a simulation, which may take long; returns an error that ends the call. May not use the
  /// request or the reply, which gRPC deletes once the call is answered.
  virtual grpc::Status make() { return grpc::Status::OK; }
  /// Frees what the call holds of its session.
  virtual void free() noexcept {}
  /// The steps computed so far, for the log.
  virtual std::int64_t computed_steps() const { return 0; }
  /// Sends the answer; the call may be deleted at once.
  virtual void answer(const grpc::Status& status) { this->Finish(status); }
  /// Tells the caller of an error in a slice.
  virtual void fail(const grpc::Status& status) { end(status); }

  /// Lets a worker make the simulation. Returns false if the call has ended; it may be deleted.
  bool make_now() noexcept {
    grpc::Status made;
    state_ = State::making;
    try {
      made = make();
    } catch (...) {
      made = errors::from_current_exception();
    }
    State expected = State::making;
    if (!state_.compare_exchange_strong(expected, State::other)) {
      free_last();
      return false;
    }
    if (!made.ok()) fail(cancelled() ? errors::cancelled() : made);
    return made.ok();
  }
  /// Gives back what others may use.
  void release() noexcept {
    free();
    permit_.give_back();
  }
  /// Returns the status that the caller is told: a computation that was stopped while its caller is
  /// there was stopped by the end of the server.
  grpc::Status told(const grpc::Status& status) const {
    const bool stopped = status.error_code() == grpc::CANCELLED;
    return stopped && !cancelled() && host_.lifecycle.stopping() ? errors::shutting_down() : status;
  }
  /// Ends the call; it may be deleted. The caller who is there finds the place free.
  void end(const grpc::Status& of_call) {
    const grpc::Status status = told(of_call);
    log_.finish(status, computed_steps());
    if (cancelled() && !status.ok()) {
      state_ = State::answered;
      this->Finish(status);
      return free_last();
    }
    release();
    answer(status);
  }
  /// Notes that the caller has left.
  void caller_left() {
    cancelled_ = true;
    stop_.request_stop();
  }
  bool cancelled() const { return cancelled_; }
  /// Requests a stop when the caller cancels or the server interrupts its calls.
  std::stop_token stop() const { return stop_.get_token(); }

  Host& host_;
  CallLog log_;
  Permit permit_;
  MemoryLease memory_;

 private:
  enum class State : std::uint8_t { other, making, answered };

  void free_last() {
    release();
    remove_if_last();
  }
  void remove_if_last() {
    if (state_ == State::answered && !one_has_left_.exchange(true)) return;
    Host& host = host_;
    const bool runs = runs_;
    delete this;
    if (runs) host.lifecycle.leave();
  }

  bool runs_ = false;  // counted by the lifecycle
  std::atomic<bool> cancelled_ = false;
  std::atomic<State> state_ = State::other;
  std::atomic<bool> one_has_left_ = false;
  std::stop_source stop_;
  std::stop_callback<RequestStop> shutdown_;
};

}  // namespace stiefel::server
