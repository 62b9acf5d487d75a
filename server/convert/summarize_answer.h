#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <utility>

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
  /// The request must outlive this object.
  SummarizeAnswer(SessionRef session, const v1::SummarizeRequest& request)
      : session_(std::move(session)),
        request_(request),
        has_checkpoint_(!request.checkpoint().empty()) {}

  /// `read`, `make` and `start` are called in this order. They throw errors of the request, and
  /// Stopped (stiefel/stop.h) on a stop request of the surrounding StopScope. `read` reads what is
  /// to be computed; the call's memory comes from `memory`.
  void read(MemoryBudget& memory);
  bool was_read() const { return what_.has_value(); }
  /// Makes the summary and, if the request has no checkpoint, its first state. Does not use the
  /// request.
  void make();
  bool made() const { return summary_.has_value(); }
  /// Goes to the state of the request's checkpoint, if it has one.
  void start();
  bool started() const { return messages_.has_value(); }

  // The functions below need a start that succeeded, unless they say otherwise.

  /// Advances by a slice of so many steps, see Summary::advance, and not beyond the step of the
  /// next checkpoint.
  void advance(double slice, const std::stop_token& stop);
  /// Collects for the messages what was found on the way: events, states, a checkpoint that is due
  /// and, at the end, the statistics.
  void collect();
  /// Makes a last checkpoint, if the request asks for any and all members are at one step. Returns
  /// whether there is anything to send. May be called before the start.
  bool save();

  /// Whether a stop interrupted a reading, which may then be incomplete.
  bool interrupted() const { return summary_->interrupted(); }
  /// Whether nothing is left to compute. False before the start.
  bool done() const { return done_; }
  /// 0 before the start.
  std::int64_t computed_steps() const { return summary_ ? summary_->computed_steps() : 0; }
  const Session& session() const { return *session_; }

  /// Whether there are results to send. False before the start.
  bool has_results() const { return messages_ && !messages_->empty(); }
  /// Writes the next message over `message`: results, or only the progress if there are none.
  /// Returns whether it is the last message.
  bool next(v1::SummarizeResponse& message);

 private:
  /// Goes to the description's first state.
  void go_to_first_state();
  /// Restores the request's checkpoint. Goes to the first state if the server does not have its
  /// key.
  void restore();
  /// Returns the step at which the next checkpoint is due.
  std::int64_t next_mark() const;
  void add_checkpoint(std::int64_t step);

  const SessionRef session_;
  const v1::SummarizeRequest& request_;
  MemoryLease memory_;
  std::optional<SummaryDescription> what_;
  std::optional<Summary> summary_;
  std::optional<SummaryMessages> messages_;
  bool has_checkpoint_;
  std::int64_t last_mark_ = 0;
  bool done_ = false;
  bool finite_ = true;  ///< what was sent
};

}  // namespace stiefel::server
