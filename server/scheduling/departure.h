#pragma once

#include <atomic>
#include <cstdint>

namespace stiefel::server {

/// Answers a caller who leaves before the simulation of the call is freed. To free that of an
/// ensemble takes up to 0.1 s, whole or half made. So a caller who leaves while a worker makes it
/// is answered by OnCancel, one who leaves later by the worker before it frees. The later of gRPC
/// and the worker deletes the call.
class Departure {
 public:
  /// The worker makes the simulation here: calls `make`, and `failed` while it handles what `make`
  /// threw. Neither may use the request or the reply. Returns false if OnCancel has answered; then
  /// the worker only frees what it holds.
  template <class Make, class Failed>
  bool make(Make make, Failed failed) noexcept {
    state_ = State::making;
    try {
      make();
    } catch (...) {
      failed();
    }
    State expected = State::making;
    return state_.compare_exchange_strong(expected, State::other);
  }
  /// The worker calls this before it answers a caller who has left, and only frees afterwards.
  void answer_first() { state_ = State::answered; }
  /// Returns true if OnCancel is to answer now.
  bool answer_now() {
    State expected = State::making;
    return state_.compare_exchange_strong(expected, State::answered);
  }
  /// Called once by OnDone, and once by a worker that only frees, after it has. Returns true to the
  /// one that deletes the call.
  bool is_last() { return state_ != State::answered || one_has_left_.exchange(true); }

 private:
  enum class State : std::uint8_t { other, making, answered };
  std::atomic<State> state_ = State::other;
  std::atomic<bool> one_has_left_ = false;
};

}  // namespace stiefel::server
