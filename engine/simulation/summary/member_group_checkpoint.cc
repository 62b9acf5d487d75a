// The part of MemberGroup that saves and restores a checkpoint.
#include <utility>

#include "engine/simulation/summary/member_group.h"

namespace stiefel {

void MemberGroup::save(ByteWriter& out) const {
  std::vector<double> saved(each_saved_ * alive_.size());
  if (simulation_) simulation_->save(saved);
  auto left = std::span<const double>(saved);
  for (const Member& member : members_) {
    for (const Accumulators& one : member.accumulators) one.save(out);
    out.put(member.events);
    out.put(member.end.has_value());
    if (member.end) {
      save_end(member, out);
    } else {
      const auto theirs = left.first(each_saved_);
      out.put(std::vector<double>(theirs.begin(), theirs.end()));
      left = left.subspan(each_saved_);
    }
  }
}

void MemberGroup::save_end(const Member& member, ByteWriter& out) {
  const MemberEnd& end = *member.end;
  out.put(static_cast<std::int32_t>(end.status.outcome));
  out.put(end.status.largest_step.has_value());
  out.put(end.status.largest_step.value_or(0));
  out.put(end.last_step);
  out.put(end.ended_by);
  out.put(end.rate);
  for (const auto& last : member.last) out.put(last);
}

void MemberGroup::restore_end(Member& member, ByteReader& in) {
  MemberEnd& end = member.end.emplace();
  std::int32_t outcome = 0;
  bool has_step = false;
  double largest = 0;
  in.get(outcome);
  in.get(has_step);
  in.get(largest);
  in.get(end.last_step);
  in.get(end.ended_by);
  in.get(end.rate);
  end.status.outcome = static_cast<Outcome>(outcome);
  if (has_step) end.status.largest_step = largest;
  for (std::size_t q = 0; q < plan_.reads.size(); ++q) {
    member.last[q].resize(plan_.reads[q].size);
    in.get(member.last[q]);
  }
}

void MemberGroup::restore(std::int64_t step, bool begun, ByteReader& in) {
  std::vector<double> saved(each_saved_), all;
  std::vector<Scene> remaining;
  alive_.clear();
  for (std::size_t b = 0; b < members_.size() && in.sound(); ++b) {
    Member& member = members_[b];
    for (Accumulators& one : member.accumulators) one.restore(in);
    in.get(member.events);
    bool ended = false;
    in.get(ended);
    if (ended) {
      restore_end(member, in);
      continue;
    }
    in.get(saved);
    all.insert(all.end(), saved.begin(), saved.end());
    alive_.push_back(b);
    remaining.push_back(*member.scene);
  }
  if (!in.sound()) return;
  if (alive_.size() < members_.size()) keep(std::move(remaining));
  if (!alive_.empty()) resume(step, begun, all);
}

void MemberGroup::resume(std::int64_t step, bool begun, std::span<const double> saved) {
  simulation_->restore(step, saved);
  step_ = step;
  begun_ = begun;
  if (!begun) return;
  next_sample_ = plan_.next_sample(step);
  while (next_time_ < plan_.times.size() && plan_.times[next_time_].arrival <= step) ++next_time_;
  for (std::size_t i = 0; i < alive_.size(); ++i)
    if (!plan_.what.events.empty()) functions_.values(state(i), going(i).g);
}

}  // namespace stiefel
