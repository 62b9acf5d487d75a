#pragma once

#include <cstdint>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stiefel/client/connection.h"
#include "stiefel/client/samples.h"

namespace stiefel::client {

class Assembly;
class Layout;
class Steps;

/// The samples at from, from + every, ... and always at `to`.
struct Range {
  std::int64_t from = 0;
  std::int64_t to = 0;
  std::int64_t every = 1;
  /// When empty: quaternion and angular_velocity in a scene with `body`, else the system's blocks.
  std::vector<std::string> fields = {};
  /// Asks for a checkpoint after the last sample.
  bool return_checkpoint = false;
  /// Asks for a checkpoint after the first sample that is at least this many steps past `from`, or
  /// past the previous checkpoint; 0: none on the way.
  std::int64_t checkpoint_every = 0;
};

/// A stream of samples, many to a message, as an input range:
///
///     for (const SampleView sample : stream) use(sample.step(), sample.field("Q").values);
///
/// or batch by batch with `next_batch`. A sample larger than a message is a batch of its own. A
/// stream that breaks because the server is UNAVAILABLE is opened again and goes on where it broke,
/// also at another server if its handle created the session. Options::compute_timeout bounds the
/// whole time from construction to end, including all reopened streams. Destruction cancels the
/// stream. Not thread-safe.
class Stream {
 public:
  Stream(std::shared_ptr<const Connection> connection, std::string session_id, Range range,
         std::shared_ptr<Recreation> recreation = nullptr);
  ~Stream();
  Stream(Stream&&) noexcept = default;
  /// Deleted because it would abandon the assigned-to stream without cancelling it.
  Stream& operator=(Stream&&) = delete;

  /// Returns the next samples, null at the end. The message is valid until the next call. Throws
  /// Error.
  const v1::StreamResponse* next_batch();

  /// The last checkpoint that has arrived: one that the range asks for, or one of those that the
  /// handle asks for about once per second of work in order to create the session again.
  const std::optional<Checkpoint>& checkpoint() const { return checkpoint_; }

  /// The predicted price of the whole stream; empty before the first message.
  const v1::Price& price() const { return price_; }

  /// How the run ended; empty before the end.
  const std::optional<v1::RunStatus>& run_status() const { return run_status_; }

  /// Steps computed so far, including those of streams that broke; other states came from a cache.
  std::int64_t computed_steps() const { return computed_before_ + computed_; }

  class Iterator {
   public:
    using iterator_concept = std::input_iterator_tag;
    using value_type = SampleView;
    using difference_type = std::ptrdiff_t;

    explicit Iterator(Stream& stream) : stream_(&stream) { ++*this; }
    SampleView operator*() const { return {*batch_, index_}; }
    Iterator& operator++() {
      if (!batch_ || ++index_ == batch_->steps_size()) {
        batch_ = stream_->next_batch();
        index_ = 0;
      }
      return *this;
    }
    void operator++(int) { ++*this; }
    bool operator==(std::default_sentinel_t) const { return batch_ == nullptr; }

   private:
    Stream* stream_;
    const v1::StreamResponse* batch_ = nullptr;
    int index_ = 0;
  };

  /// May be called only once, because the stream is an input range.
  Iterator begin() { return Iterator(*this); }
  std::default_sentinel_t end() const { return {}; }

 private:
  void open();
  void resume_after(std::int64_t step);
  /// Reads the message in `batch_`. Returns whether it has samples that are whole and new.
  bool take();
  bool take_samples();
  void take_checkpoint();
  bool recovers(const grpc::Status& status, Patience& pauses, Patience& recoveries);

  std::shared_ptr<const Connection> connection_;
  std::shared_ptr<Recreation> recreation_;
  bool answered_ = false;  // whether `reader_` has received a message
  Deadline deadline_;
  v1::StreamRequest request_;
  std::int64_t every_;
  std::unique_ptr<grpc::ClientContext> context_;
  std::unique_ptr<CancelOnStop> cancel_;
  std::unique_ptr<grpc::ClientReader<v1::StreamResponse>> reader_;
  v1::StreamResponse batch_;
  /// Fields of a sample that comes in several messages.
  std::shared_ptr<Assembly> assembly_;
  std::shared_ptr<Layout> layout_;
  std::shared_ptr<Steps> steps_;  ///< of the present stream
  std::optional<Checkpoint> partial_checkpoint_;
  std::optional<Checkpoint> checkpoint_;
  v1::Price price_;
  bool has_price_ = false;
  std::optional<std::int64_t> last_step_;
  std::optional<v1::RunStatus> run_status_;
  std::int64_t computed_before_ = 0;  // steps computed by the streams that broke
  std::int64_t computed_ = 0;         // steps computed by the present stream
};

}  // namespace stiefel::client
