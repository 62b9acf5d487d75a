#include "server/metrics/open_streams.h"

#include <algorithm>

#include "server/metrics/family.h"

namespace stiefel::server {

std::vector<prometheus::MetricFamily> OpenStreams::Collect() const {
  const Clock::rep now = Clock::now().time_since_epoch().count();
  Clock::duration longest{0};
  std::size_t open = 0, late = 0;
  {
    const std::lock_guard lock(mutex_);
    open = streams_.size();
    for (const Stream* stream : streams_) {
      const Clock::rep since = stream->since_.load(std::memory_order_relaxed);
      if (since == Stream::not_waiting) continue;
      const Clock::duration waits(now - since);
      late += waits > behind;
      longest = std::max(longest, waits);
    }
  }
  using prometheus::MetricType;
  return {single("stiefel_streams_open", "Calls that answer with a stream of messages.",
                 MetricType::Gauge, static_cast<double>(open)),
          single("stiefel_streams_behind",
                 "Streams whose message has waited for its reader for more than 0.1 s.",
                 MetricType::Gauge, static_cast<double>(late)),
          single("stiefel_stream_lag_seconds",
                 "The longest time that a stream's message waits for its reader now.",
                 MetricType::Gauge, std::chrono::duration<double>(longest).count())};
}

OpenStreams::Stream::Stream(OpenStreams& all) : all_(all) {
  const std::lock_guard lock(all_.mutex_);
  all_.streams_.insert(this);
}

OpenStreams::Stream::~Stream() {
  const std::lock_guard lock(all_.mutex_);
  all_.streams_.erase(this);
}

void OpenStreams::Stream::writing() noexcept {
  since_.store(Clock::now().time_since_epoch().count(), std::memory_order_relaxed);
}

}  // namespace stiefel::server
