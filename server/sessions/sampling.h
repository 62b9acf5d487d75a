#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "server/sessions/cursor.h"

namespace stiefel::server {

/// A state as bytes (checkpoint_bytes.h), and its step.
struct EncodedCheckpoint {
  std::int64_t step = 0;
  std::string bytes;
};

/// Samples side by side: the bytes of each field are (samples, rows, cols), as `write_field` writes
/// them.
struct Batch {
  std::vector<std::int64_t> steps;
  std::vector<double> times;
  std::vector<std::string> fields;

  std::size_t size() const { return steps.size(); }
};

/// The samples at from, from + every, ... and always at `to`, a batch at a time. At a numerical
/// stop the last sample is the last good state. For one thread at a time.
class Sampling {
 public:
  /// A batch is full when it holds so many bytes; one sample always fits.
  static constexpr std::size_t batch_bytes = std::size_t{128} << 10;

  struct Range {
    std::int64_t from, to, every;
    /// Checkpoints at the first sample so many steps past `from` or the checkpoint before; where
    /// the way to the next sample is longer, also between samples, unless the system has a closed
    /// form. 0: none.
    std::int64_t checkpoint_every = 0;
    bool checkpoint_at_end = false;

    bool checkpoints() const { return checkpoint_every > 0 || checkpoint_at_end; }
  };
  Sampling(Session& session, std::vector<std::size_t> fields, Range range,
           const std::stop_token& stop = {});

  /// One slice: goes on until the batch is full, all is sampled or the slice is over. A stop
  /// request ends it with the last good state.
  void fill(Batch& batch, const std::stop_token& stop = {});
  bool full(const Batch& batch) const {
    return batch.size() >= capacity_ || !checkpoint_.bytes.empty();
  }
  /// Nothing comes after what is in the batch: `to` is reached, or see `cursor().run_status()`.
  bool done() const { return done_; }
  /// Until the next `fill`: see Cursor.
  void rest() { cursor_.rest(); }
  /// Ends with the last good state.
  void cancel(Batch& batch);
  /// The checkpoint of the last sample or of a state after it, if the range asks for one there:
  /// before the next `fill`, once. Without bytes if there is none.
  EncodedCheckpoint take_checkpoint() { return std::exchange(checkpoint_, {}); }

  /// Makes the batch empty; its memory is kept.
  void clear(Batch& batch) const;
  /// Cuts the bytes to the samples there are. Before sending.
  void trim(Batch& batch) const;

  const Cursor& cursor() const { return cursor_; }
  /// Units of work that it is predicted to take, and bytes of its fields, if it reaches `to`.
  double work() const { return session_.work(cursor_.start(), range_.to); }
  std::uint64_t bytes() const;
  /// The samples a batch holds at most.
  std::size_t capacity() const { return capacity_; }

 private:
  /// Where the cursor goes next: to a sample, or to a checkpoint before it.
  std::int64_t target() const;
  void checkpoint();
  void sample(Batch& batch);
  void end();

  Session& session_;
  const std::vector<std::size_t> fields_;
  const Range range_;
  Cursor cursor_;
  std::size_t capacity_;
  std::int64_t next_;
  std::int64_t last_ = -1;
  std::int64_t last_checkpoint_;
  EncodedCheckpoint checkpoint_;
  bool done_ = false;
};

}  // namespace stiefel::server
