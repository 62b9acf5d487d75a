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
  void add_checkpoint(std::int64_t step, std::string bytes) {
    checkpoint_step_ = step;
    checkpoint_ = std::move(bytes);
    checkpoint_sent_ = 0;
  }
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
  void next_checkpoint(v1::CheckpointPart& part);
  /// Takes the fields of the first items, events or states, that fit into a message. An item holds
  /// numbers field after field: of one member or, with `by_members`, of all.
  template <class Items>
  void split_fields(const Items& items, bool by_members);
  /// Writes the next fields and, by `write`, the rest of their items.
  template <class Items, class Batch, class Write>
  void next_batch(Items& items, bool by_members, Batch& batch, const Write& write);

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
