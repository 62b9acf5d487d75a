#include "engine/summary/event_reports.h"

#include <algorithm>
#include <utility>

#include "engine/summary/states_at_times.h"

namespace stiefel {

bool EventReports::waits(const Member& member) const {
  for (std::size_t e = 0; e < plan_.what.events.size(); ++e) {
    const std::uint64_t limit = plan_.what.events[e].limit;
    if (limit == 0 || member.events[e] < limit) return true;
  }
  return false;
}

std::vector<EventReports::Zero> EventReports::zeros(Member& member, const LastStep& step,
                                                    const std::stop_token& stop) {
  std::vector<Zero> found;
  functions_.values(step.now, g_);
  for (std::size_t e = 0; e < g_.size(); ++e) {
    const EventDescription& event = plan_.what.events[e];
    if (event.limit > 0 && member.events[e] >= event.limit) continue;
    if (!crosses(member.g[e], g_[e], event.direction)) continue;
    const auto g = [&](double fraction) -> std::optional<double> {
      const Simulation* now = member.between.at(step.to - 1, fraction, step.before, stop);
      if (now == nullptr) return std::nullopt;
      return functions_.value(*now, e);
    };
    found.push_back({e, plan_.discrete ? 1 : zero_fraction(g, member.g[e], g_[e])});
  }
  member.g = g_;
  std::ranges::sort(found, {}, [](const Zero& z) { return std::pair(z.fraction, z.event); });
  return found;
}

std::optional<EventReports::Terminal> EventReports::report(Member& member, std::size_t index,
                                                           const LastStep& step,
                                                           const std::stop_token& stop) {
  for (const auto& [e, fraction] : zeros(member, step, stop)) {
    const EventDescription& event = plan_.what.events[e];
    const Simulation* at = &step.now;
    if (fraction < 1)
      if (const auto* there = member.between.at(step.to - 1, fraction, step.before, stop))
        at = there;
    const long double steps = static_cast<long double>(step.to - 1) + fraction;
    reported_.push_back({e, step.to - 1, fraction,
                         static_cast<double>(steps * member.scene->step()), index,
                         written_fields(plan_, *at)});
    const std::uint64_t count = ++member.events[e];
    if (event.terminal && count >= std::max<std::uint64_t>(event.limit, 1))
      return Terminal{e, fraction};
  }
  return std::nullopt;
}

}  // namespace stiefel
