#include "engine/summary/event_reports.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/summary/states_at_times.h"

namespace stiefel {

bool EventReports::waits(const Member& member) const {
  for (std::size_t e = 0; e < plan_.what.events.size(); ++e)
    if (waits(member, e)) return true;
  return false;
}

std::optional<double> EventReports::slope(Member& member, std::size_t event, std::int64_t k,
                                          double fraction, std::span<const double> saved,
                                          const std::stop_token& stop) {
  constexpr double delta = 0.03, of_step[] = {45.0 / 60, -9.0 / 60, 1.0 / 60};
  std::vector<double> there(saved.begin(), saved.end());
  if (!member.between().direct() && fraction != 0) {
    const Simulation* now = member.between().at(k, fraction, saved, stop);
    if (now == nullptr) return std::nullopt;
    now->save(there);
    fraction = 0;
  }
  const double period = functions_.period(event);
  double sum = 0;
  for (int j = 1; j <= 3; ++j) {
    double g[2];
    for (const int side : {0, 1}) {
      const double away = side == 0 ? -j * delta : j * delta;
      const Simulation* now = member.between().at(k, fraction + away, there, stop);
      if (now == nullptr) return std::nullopt;
      g[side] = functions_.value(*now, event);
    }
    const double change = g[1] - g[0];
    sum += of_step[j - 1] * (period > 0 ? std::remainder(change, period) : change);
  }
  return sum / delta;
}

void EventReports::values(Member& member, std::int64_t k, const Simulation& now,
                          std::vector<double>& g, const std::stop_token& stop) {
  functions_.values(now, g);
  std::vector<double> saved;
  for (std::size_t e = 0; e < g.size(); ++e) {
    if (!plan_.what.events[e].extremum || !waits(member, e)) continue;
    saved.resize(now.saved_size());
    now.save(saved);
    g[e] = slope(member, e, k, 0, saved, stop)
               .value_or(std::numeric_limits<double>::quiet_NaN());  // at which no event is
  }
}

std::vector<EventReports::Zero> EventReports::zeros(Member& member, const LastStep& step,
                                                    const std::stop_token& stop) {
  std::vector<Zero> found;
  constexpr double width_of_extremum = 0x1p-46;  // below the error of g'
  values(member, step.to, step.now, g_, stop);
  for (std::size_t e = 0; e < g_.size(); ++e) {
    const EventDescription& event = plan_.what.events[e];
    if (!waits(member, e) || !crosses(member.g[e], g_[e], event.direction)) continue;
    const double period = event.extremum ? 0 : functions_.period(e);
    if (period > 0 && std::abs(g_[e] - member.g[e]) >= period / 2) continue;
    const auto g = [&](double fraction) -> std::optional<double> {
      if (event.extremum) return slope(member, e, step.to - 1, fraction, step.before, stop);
      const Simulation* now = member.between().at(step.to - 1, fraction, step.before, stop);
      if (now == nullptr) return std::nullopt;
      return functions_.value(*now, e);
    };
    const double width = event.extremum ? width_of_extremum : 0x1p-52;
    found.push_back({e, plan_.discrete ? 1 : zero_fraction(g, member.g[e], g_[e], width)});
  }
  member.g = g_;
  std::ranges::sort(found, {}, [](const Zero& z) { return std::pair(z.fraction, z.event); });
  return found;
}

std::optional<EventReports::Terminal> EventReports::report(Member& member, const LastStep& step,
                                                           const std::stop_token& stop) {
  for (const auto& [e, fraction] : zeros(member, step, stop)) {
    const EventDescription& event = plan_.what.events[e];
    const Simulation* at = &step.now;
    if (fraction < 1)
      if (const auto* there = member.between().at(step.to - 1, fraction, step.before, stop))
        at = there;
    const long double steps = static_cast<long double>(step.to - 1) + fraction;
    reported_.push_back({e, step.to - 1, fraction, static_cast<double>(steps * plan_.step_size),
                         member.index, written_fields(plan_, *at)});
    const std::uint64_t count = ++member.events[e];
    if (event.terminal && count >= std::max<std::uint64_t>(event.limit, 1))
      return Terminal{e, fraction};
  }
  return std::nullopt;
}

}  // namespace stiefel
