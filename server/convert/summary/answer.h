#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <utility>

#include "server/convert/summary/messages.h"
#include "server/limits/memory_budget.h"
#include "server/sessions/session.h"
#include "stiefel/summary.h"
#include "stiefel/v1/summary.pb.h"

namespace stiefel::server {

/// Answers a Summarize: computes the summary piece by piece and writes its messages.
class SummarizeAnswer {
 public:
  /// The request must outlive this object.
  SummarizeAnswer(SessionLease session, const v1::SummarizeRequest& request)
      : session_(std::move(session)), request_(request) {}

  /// Checks the request and goes to its first state, or to that of its checkpoint. The summary's
  /// memory comes from `memory`. Throws Stopped (stiefel/stop.h) on a stop request of the
  /// surrounding StopScope. An error ends the call.
  grpc::Status start(MemoryBudget& memory);
  bool started() const { return summary_.has_value(); }

  // The functions below need a start that succeeded, unless they say otherwise.

  /// Advances by at most `steps` steps, and not beyond the step of the next checkpoint.
  void advance(std::int64_t steps, const std::stop_token& stop);
  /// Collects for the messages what was found on the way: events, states, a checkpoint that is due
  /// and, at the end, the statistics.
  void collect();
  /// Ends the summary for a server that stops: with what there is and, on request, a checkpoint
  /// from which another server goes on. Needs `aligned()`.
  void cut_short();

  /// Whether all members are at one step.
  bool aligned() const { return summary_->aligned(); }
  /// Whether a stop interrupted a reading, which may then be incomplete.
  bool interrupted() const { return summary_->interrupted(); }
  /// Whether nothing is left to compute. False before the start.
  bool done() const { return done_; }
  /// The groups of members that advance together.
  std::size_t width() const { return summary_->width(); }
  /// 0 before the start.
  std::int64_t computed_steps() const { return summary_ ? summary_->computed_steps() : 0; }
  const Session& session() const { return *session_; }

  /// Whether there are results to send. False before the start.
  bool has_results() const { return messages_ && !messages_->empty(); }
  /// Writes the next message over `message`: results, or only the progress if there are none.
  /// Returns whether it is the last message.
  bool next(v1::SummarizeResponse& message);

 private:
  /// Restores the request's checkpoint, or starts at the request's first state if there is none or
  /// this server does not have its key.
  grpc::Status find_first_state(Summary& summary);
  void write_price(const Summary& summary);
  /// Returns the step at which the next checkpoint is due.
  std::int64_t next_mark() const;
  void add_checkpoint(std::int64_t step);

  const SessionLease session_;
  const v1::SummarizeRequest& request_;
  MemoryLease memory_;
  std::optional<Summary> summary_;
  std::optional<SummaryMessages> messages_;
  v1::Price price_;  ///< empty once it is sent
  bool checkpoint_ignored_ = false;
  std::int64_t last_mark_ = 0;
  bool done_ = false;
};

}  // namespace stiefel::server
