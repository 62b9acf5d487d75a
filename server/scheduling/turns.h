#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <mutex>
#include <stop_token>

#include "stiefel/stop.h"

namespace stiefel::server {

/// The places in which calls compute, one for each core that computes: a fair lock. A call takes a
/// place once it has computed for `free_time`, and gives it to another that waits after a turn.
/// Principals have equal shares of the places. Within a share a call that has computed less goes
/// first; it also goes before other shares as long as its own is at most `lead` ahead of them. One
/// place more is there for calls that have computed for less than `medium_time`; the others let
/// every thread of the system go first that wants a processor. Thread-safe.
class Turns {
 public:
  using Clock = std::chrono::steady_clock;
  using Time = Clock::duration;
  static constexpr std::chrono::microseconds free_time{200};
  /// The length of a turn, and how often a call looks whether a shorter one waits.
  static constexpr std::chrono::microseconds turn{2000}, look{250};
  /// The time for which a call is a short one, and that for which it is a medium one.
  static constexpr std::chrono::milliseconds short_time{2}, medium_time{20};
  static constexpr std::chrono::milliseconds lead{20};
  /// The time in which a call whose time is up may end its piece of work.
  static constexpr std::chrono::milliseconds last_piece{100};
  /// How often a call looks whether its caller has left, while it computes and while it waits.
  static constexpr std::chrono::milliseconds patience{5}, waiting_patience{50};

  /// What the calls of one principal have computed.
  class Share {
    friend class Turns;
    Time used_{};      // guarded by the mutex of the Turns
    int waiting_ = 0;  // guarded by the mutex of the Turns
  };
  class OfCall;

  /// `now` is for tests.
  using Now = Clock::time_point (*)();
  explicit Turns(int places, Now now = &Clock::now) : now_(now), free_(places) {}
  Turns(const Turns&) = delete;
  Turns& operator=(const Turns&) = delete;

  /// The calls that wait for a place.
  std::size_t waiting() const { return waiting_.load(std::memory_order_relaxed); }
  /// The places that nobody has.
  int idle() const { return std::max(0, free_.load(std::memory_order_relaxed)); }
  /// The time for which calls and their helpers have computed.
  Time computed() const { return Time(computed_.load(std::memory_order_relaxed)); }

  /// Takes a place for a helper; returns whether there was one for which no call waits.
  bool take_idle();
  /// Gives back the place of a helper.
  void give_idle();

 private:
  using Queue = std::list<OfCall*>;

  /// Waits for a place; the call has none when its stop is requested before.
  void take(OfCall& call, std::unique_lock<std::mutex>& lock);
  /// Takes back the place of a call, which has computed until `now`.
  void take_back(OfCall& call, Clock::time_point now);
  /// Gives the free places to calls that wait.
  void grant();
  /// Takes a call out of the queue.
  void leave(Queue::iterator place);
  Queue::iterator next();

  const Now now_;
  std::mutex mutex_;
  std::atomic<int> free_;  // places; changes under mutex_
  std::atomic<std::size_t> waiting_ = 0;
  std::atomic<Time::rep> computed_ = 0;
  // Guarded by mutex_.
  Time served_{};  // the most that a share had used when one of its calls began its turn
  Queue queue_;
};

/// The turn of one call, for the thread that computes it.
class Turns::OfCall final : public Turn {
 public:
  /// The stop of `stop` is requested once `left` returns that the caller has left, and `last_piece`
  /// after the call has computed for `most`. All must outlive the object.
  OfCall(Turns& turns, Share& share, std::stop_source& stop, std::function<bool()> left,
         Time most = Time::max())
      : turns_(turns), share_(share), stop_(stop), left_(std::move(left)), most_(most) {}
  ~OfCall() { give(); }
  OfCall(const OfCall&) = delete;
  OfCall& operator=(const OfCall&) = delete;

  void pass() override {
    if (const auto now = turns_.now_(); now >= look_at_) pass_at(now);
  }
  /// Adds the time for which helpers have computed for the call.
  void add(Time helped) { helped_ += helped; }
  /// Begins a call, or one of several requests in a call.
  void begin();
  /// Takes a place now, before work without stop points.
  void take() {
    look_at_ = {};
    pass();
  }
  /// Gives the place back, if the call has one.
  void give();
  /// The time for which the call and its helpers have computed since its begin, where it computes
  /// or has just given its place back.
  Time spent() const { return spent_ + helped_ + (turns_.now_() - began_); }
  /// Whether the call has computed for as long as it may.
  bool time_is_up() const { return time_is_up_; }
  /// Calls `wait`, which waits for the peer, without a place.
  template <class Wait>
  auto without_place(const Wait& wait) {
    give();
    const auto result = wait();
    began_ = look_at_ = turns_.now_();
    return result;
  }

 private:
  friend class Turns;
  enum class Length { short_call, medium, long_call };

  void pass_at(Clock::time_point now);
  /// Lets other threads of the system go before this one, or no longer.
  void yield_to_others(bool yields) noexcept;
  void look_for_caller(Clock::time_point now);
  Length length() const {
    if (spent_ < short_time) return Length::short_call;
    return spent_ < medium_time ? Length::medium : Length::long_call;
  }

  Turns& turns_;
  Share& share_;
  std::stop_source& stop_;
  const std::function<bool()> left_;
  const Time most_;
  Clock::time_point began_ = turns_.now_(), look_at_ = began_ + free_time;
  Clock::time_point look_for_caller_at_ = began_ + patience;
  Time spent_{}, helped_{};
  bool holds_ = false;
  bool yields_ = false;  // see yield_to_others
  bool time_is_up_ = false;
  bool granted_ = false;  // guarded by the mutex of the Turns
  std::condition_variable granted_now_;
  Queue place_{this};  // in the queue while the call waits
};

}  // namespace stiefel::server
