#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "server/scheduling/turns.h"
#include "stiefel/crew.h"

namespace stiefel::server {

/// Threads that help calls with work that is divided, such as the members of an ensemble, in places
/// that no call wants: a helper leaves between two items when a call waits for a place.
/// Thread-safe.
class Helpers {
 public:
  class OfCall;

  Helpers(Turns& turns, int threads);
  ~Helpers();
  Helpers(const Helpers&) = delete;
  Helpers& operator=(const Helpers&) = delete;

 private:
  void work(const std::stop_token& stop);
  /// Asks for helpers of the call's next run.
  void call(OfCall& leader, std::size_t wanted);
  /// Waits until nobody helps the call.
  void forget(OfCall& leader);
  /// Returns the call with the fewest helpers of those that want more.
  OfCall* next() const;

  Turns& turns_;
  std::mutex mutex_;
  std::condition_variable wake_, left_;
  std::vector<OfCall*> leaders_;  // guarded by mutex_
  std::vector<std::jthread> threads_;
};

/// The crew of a call: its own thread, and helpers.
class Helpers::OfCall final : public Crew {
 public:
  OfCall(Helpers& helpers, Turns::OfCall& turn) : helpers_(helpers), turn_(turn) {}
  ~OfCall() override {
    if (listed_) helpers_.forget(*this);
  }

  std::size_t threads_at_hand() override;
  void run(std::size_t count, double nanoseconds, Item item, void* context) override;

 private:
  friend class Helpers;

  Helpers& helpers_;
  Turns::OfCall& turn_;
  Team team_;
  bool listed_ = false;  // of this thread
  // Guarded by the mutex of the Helpers, `helping_` to be changed.
  std::size_t wanted_ = 0;
  std::atomic<std::size_t> helping_ = 0;
};

}  // namespace stiefel::server
