#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "server/convert/parts.h"
#include "server/sessions/session.h"
#include "stiefel/summary.h"
#include "stiefel/v1/summary.pb.h"

namespace stiefel::server {

/// Collects what a Summarize has to send and makes messages of it, each with at most
/// `max_reply_bytes` of arrays.
class SummaryMessages {
 public:
  /// `session` must outlive this object.
  SummaryMessages(const Session& session, const SummaryDescription& what);

  void add(std::vector<Event> events);
  void add(std::vector<StateAtTime> states);
  void add_checkpoint(std::int64_t step, std::string bytes);
  void add(const std::vector<SummaryArray>& statistics);

  bool empty() const {
    return events_.empty() && states_.empty() && fields_left_.empty() && checkpoint_.empty() &&
           statistics_.empty();
  }
  /// Writes the next message over `message`, which must be empty.
  void next(v1::SummarizeResponse& message);
  /// The bytes of the fields of one event, and of one state with all its members.
  std::size_t event_bytes() const { return event_numbers_ * sizeof(double); }
  std::size_t state_bytes() const { return event_bytes() * members_; }

 private:
  void next_events(v1::EventBatch& batch);
  void next_states(v1::StateBatch& batch);
  void next_checkpoint(v1::CheckpointPart& part);
  /// Takes the fields of `count` events or states. `numbers(i)` holds the numbers of item i, field
  /// after field: of one member or, with `by_members`, of all members.
  template <class Numbers>
  void split_fields(std::size_t count, bool by_members, const Numbers& numbers);

  const Session& session_;
  std::vector<std::size_t> fields_;  ///< indices of the fields in the session
  std::size_t members_;
  std::size_t event_numbers_ = 0;
  std::deque<Event> events_;
  std::deque<StateAtTime> states_;
  std::size_t batch_ = 0;  ///< the events or states whose fields are being sent
  Parts fields_left_;      ///< the fields of these that are left
  std::int64_t checkpoint_step_ = 0;
  std::string checkpoint_;
  std::size_t checkpoint_sent_ = 0;
  Parts statistics_;
};

}  // namespace stiefel::server
