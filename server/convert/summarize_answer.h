#pragma once

#include <cstdint>
#include <stop_token>

#include "server/convert/messages.h"
#include "server/convert/resolve.h"
#include "server/scheduling/memory_budget.h"
#include "server/sessions/registry.h"
#include "stiefel/summary.h"
#include "stiefel/v1/summary.pb.h"

namespace stiefel::server {

/// Converts a request. Does not check its numbers, which Summary checks. Throws INVALID_ARGUMENT.
SummaryDescription from_proto(const v1::SummarizeRequest& request);

/// Answers a Summarize: computes the summary piece by piece and writes its messages.
class SummarizeAnswer {
 public:
  /// Reads the request, which must outlive this object, takes memory for the summary, and goes to
  /// its first state or that of its checkpoint. Throws errors of the request, and Stopped
  /// (stiefel/stop.h), as `advance` does.
  SummarizeAnswer(SessionRef session, const v1::SummarizeRequest& request, MemoryLease& memory);

  /// Advances by a slice of so many steps, see Summary::advance, and not beyond the step of the
  /// next checkpoint. Collects for the messages what was found on the way: events, states, a
  /// checkpoint that is due and, at the end, the statistics.
  void advance(double slice, const std::stop_token& stop);
  /// Makes a last checkpoint, if the request asks for any and all members are at one step. Returns
  /// whether there is anything to send; nothing after a stop that `interrupted` a reading.
  bool save(bool interrupted);
  std::int64_t computed_steps() const { return summary_->computed_steps(); }

  /// Whether there are results to send.
  bool has_results() const { return !messages_.empty(); }
  /// Writes the next message over `message`: results, or only the progress if there are none.
  /// Returns whether it is the last message.
  bool next(v1::SummarizeResponse& message);

 private:
  void go_to_first_state();
  void restore();
  /// Returns the step at which the next checkpoint is due.
  std::int64_t next_mark() const;
  void add_checkpoint();

  const SessionRef session_;
  const v1::SummarizeRequest& request_;
  const std::string digest_;  ///< of everything in the request that determines its summary
  std::unique_ptr<Summary> summary_;
  SummaryMessages messages_;
  std::int64_t last_mark_ = 0;
  bool finite_ = true;  ///< what was sent
};

}  // namespace stiefel::server
