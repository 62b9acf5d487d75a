// The part of MemberGroup that saves and restores a checkpoint.
#include <utility>

#include "engine/summary/member_group.h"

namespace stiefel {

void MemberGroup::save(ByteWriter& out) const {
  std::vector<double> saved(motion_.saved_size());
  motion_.save(saved);
  auto waiting = std::span<const double>(saved);
  for (const Member& member : members_) {
    member.save(out);
    if (member.end) continue;
    const auto theirs = waiting.first(motion_.each_saved());
    out.put(std::vector<double>(theirs.begin(), theirs.end()));
    waiting = waiting.subspan(motion_.each_saved());
  }
}

void MemberGroup::restore(std::int64_t step, bool begun, ByteReader& in) {
  std::vector<double> state(motion_.each_saved()), all;
  std::vector<std::size_t> going;
  for (std::size_t b = 0; b < members_.size() && in.sound(); ++b) {
    members_[b].restore(plan_, in);
    if (members_[b].end) continue;
    in.get(state);
    all.insert(all.end(), state.begin(), state.end());
    going.push_back(b);
  }
  if (!in.sound()) return motion_.remove_all();
  motion_.resume(std::move(going), step, all);
  if (done()) return;
  begun_ = begun;
  if (!begun) return;
  next_sample_ = plan_.next_sample(step);
  times_.pass(step);
  for (std::size_t i = 0; i < left(); ++i) events_.begin(member(i), step, motion_.state(i), {});
}

}  // namespace stiefel
