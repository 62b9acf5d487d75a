#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "server/sessions/sampling.h"
#include "server/sessions/server_session.h"
#include "stiefel/summary.h"
#include "stiefel/v1/summary.pb.h"

namespace stiefel::server {

/// Collects what a Summarize has to send and makes messages of it: of `Sampling::batch_bytes` of
/// events or states, of one that is larger, of a checkpoint, or of the statistics.
class SummaryMessages {
 public:
  /// `session` must outlive this object.
  SummaryMessages(const Session& session, const SummaryDescription& what);

  void add(std::vector<Event> events);
  void add(std::vector<StateAtTime> states);
  void add_checkpoint(std::int64_t step, std::string bytes) {
    checkpoint_.set_step(step);
    checkpoint_.set_data(std::move(bytes));
  }
  void add(const std::vector<SummaryArray>& statistics);

  bool empty() const {
    return events_.empty() && states_.empty() && checkpoint_.data().empty() && statistics_.empty();
  }
  /// Writes the next message over `message`, which must be empty.
  void next(v1::SummarizeResponse& message);
  /// The bytes of the fields of one event, and of one state with all its members.
  std::size_t event_bytes() const { return event_numbers_ * sizeof(double); }
  std::size_t state_bytes() const { return event_bytes() * members_; }

 private:
  /// Moves the first items, events or states, to a message: their fields and, by `write`, the rest.
  /// An item holds numbers field after field: of one member or, with `by_members`, of all.
  template <class Items, class Batch, class Write>
  void take(Items& items, bool by_members, Batch& batch, const Write& write);

  const Session& session_;
  std::vector<std::size_t> fields_;  ///< indices of the fields in the session
  std::size_t members_;
  std::size_t event_numbers_ = 0;
  std::deque<Event> events_;
  std::deque<StateAtTime> states_;
  v1::Checkpoint checkpoint_;
  google::protobuf::RepeatedPtrField<v1::Field> statistics_;
};

}  // namespace stiefel::server
