#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <stop_token>
#include <vector>

#include "server/sessions/sampling.h"
#include "stiefel/v1/run.pb.h"

namespace stiefel::server {

/// Answers a Stream: takes samples and writes its messages.
class StreamAnswer {
 public:
  /// The right to hold a large simulation, given back with its last copy.
  using Place = std::shared_ptr<void>;

  /// `take_place` waits for a place of its principal. A large simulation is held only in a place,
  /// and not while the reader lets the stream wait.
  StreamAnswer(Session& session, std::vector<std::size_t> fields, const Sampling::Range& range,
               std::function<Place()> take_place);

  /// Takes samples for a slice. Throws Stopped (stiefel/stop.h).
  void advance(const std::stop_token& stop);
  /// Whether a batch is full, or has waited for others to fill it, or all samples are taken.
  bool has_results() const;
  /// Makes a last checkpoint. Returns whether there is anything to send.
  bool save(bool /*interrupted*/) { return sampling_.save(); }
  /// Writes the next message over `message`, which must be empty. Returns whether it is the last.
  bool next(v1::StreamResponse& message);

 private:
  using Clock = std::chrono::steady_clock;

  void rest();

  Session& session_;
  const std::vector<std::size_t> fields_;
  const std::function<Place()> take_place_;
  Place place_;
  Sampling sampling_;
  Clock::time_point begin_ = Clock::now();  ///< of the slice with the first sample of the batch
  bool finite_ = true;
};

}  // namespace stiefel::server
