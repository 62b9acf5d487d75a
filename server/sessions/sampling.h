#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/cursor.h"
#include "server/sessions/field_bytes.h"

namespace stiefel::server {

/// A checkpoint as bytes (checkpoint_bytes.h), and its step.
struct EncodedCheckpoint {
  std::int64_t step = 0;
  std::string bytes;
};

/// Samples in columns: `fields` has one array of bytes per field, of shape (samples, rows, cols),
/// in the format of `write_field`. The checkpoint, which has no bytes if there is none, is that of
/// the last sample or of a state after it.
struct Batch {
  std::vector<std::int64_t> steps;
  std::vector<double> times;
  std::vector<std::string> fields;
  EncodedCheckpoint checkpoint;

  std::size_t size() const { return steps.size(); }
};

/// Takes the samples at from, from + every, ... and always at `to`, a batch at a time. After a
/// numerical stop the last sample is the last good state. For one thread at a time.
class Sampling {
 public:
  /// The most bytes of a batch; one sample always fits.
  static constexpr std::size_t batch_bytes = std::size_t{128} << 10;

  struct Range {
    std::int64_t from, to, every;
    /// The steps between two checkpoints; 0 for none. A checkpoint is taken at the first sample at
    /// least this far past `from` or past the previous checkpoint; where the next sample is farther
    /// away than this, also between samples, unless the system has a closed form.
    std::int64_t checkpoint_every = 0;
    bool checkpoint_at_end = false;

    bool checkpoints() const { return checkpoint_every > 0 || checkpoint_at_end; }
  };
  Sampling(Session& session, std::vector<std::size_t> fields, Range range);

  /// Runs one slice: samples until the batch is full, all samples are taken, the slice is over or a
  /// stop is requested.
  void fill(const std::stop_token& stop = {});
  bool full() const { return batch_.size() >= capacity_ || !batch_.checkpoint.bytes.empty(); }
  bool empty() const { return batch_.size() == 0; }
  /// Whether no sample follows those in the batch: `to` is reached, or the run ended early with
  /// `cursor().run_status()`.
  bool done() const { return done_; }
  /// Calls `Cursor::suspend`, until the next `fill`.
  void suspend() { cursor_.suspend(); }
  /// Stops before the end. Makes a checkpoint of the last good state, if the range asks for any.
  /// Returns whether samples or a checkpoint are there to be sent.
  bool save();
  /// Returns what was sampled since the last call.
  Batch take();

  const Cursor& cursor() const { return cursor_; }

 private:
  /// Returns where the cursor goes next: to a sample, or to a checkpoint before it.
  std::int64_t target() const;
  void checkpoint() {
    last_checkpoint_ = cursor_.step();
    batch_.checkpoint = {last_checkpoint_, encode_checkpoint(session_, cursor_.simulation())};
  }
  void sample();
  void end() {
    done_ = true;
    if (range_.checkpoint_at_end) checkpoint();
  }

  Session& session_;
  const std::vector<std::size_t> fields_;
  const Range range_;
  Cursor cursor_;
  std::size_t capacity_;
  std::int64_t next_;
  std::int64_t last_ = -1;
  std::int64_t last_checkpoint_;
  Batch batch_;
  bool done_ = false;
};

}  // namespace stiefel::server
