#include "engine/summary/states_at_times.h"

#include <algorithm>

#include "engine/summary/accumulators.h"

namespace stiefel {

std::vector<double> written_fields(const Plan& plan, const Simulation& now) {
  std::vector<double> numbers(plan.state_size);
  auto left = std::span(numbers);
  for (const std::size_t index : plan.fields) {
    const auto size = field_size(now.fields(), index);
    now.write(index, left.first(size));
    left = left.subspan(size);
  }
  for (double& number : numbers) number = canonical(number);
  return numbers;
}

void StatesAtTimes::write(Member& member, const LastStep& step, double up_to,
                          const std::stop_token& stop) {
  for (std::size_t j = next_; j < plan_.times.size() && plan_.times[j].arrival <= step.to; ++j) {
    const Plan::Time& time = plan_.times[j];
    const bool between = time.arrival > time.before;
    if ((between ? time.fraction : 1) > up_to) return;
    reached_ = std::max(reached_, j + 1);
    const Simulation* now = &step.now;
    if (between && direct_)
      now = member.between().at_first_of(std::span(plan_.what.times).subspan(j), stop);
    else if (between)
      now = member.between().at(time.before, time.fraction, step.before, stop);
    if (now == nullptr) continue;
    const std::vector<double> numbers = written_fields(plan_, *now);
    // Writes field after field, in each field member after member.
    auto& out = states_[j - first_time_].fields;
    const std::size_t members = out.size() / plan_.state_size;
    std::size_t from = 0;
    for (const std::size_t field : plan_.fields) {
      const auto size = field_size(now->fields(), field);
      const std::size_t to = from * members + member.index * size;
      std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(from), size,
                  out.begin() + static_cast<std::ptrdiff_t>(to));
      from += size;
    }
  }
}

}  // namespace stiefel
