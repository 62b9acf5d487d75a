#include "engine/summary/events.h"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace stiefel {
namespace {

/// Whether a zero of g lies after a state with g = `before`, up to the next state, where g =
/// `after`.
bool crosses(double before, double after, Direction direction) {
  const bool rising = before < 0 && after >= 0, falling = before > 0 && after <= 0;
  return (rising && direction != Direction::falling) || (falling && direction != Direction::rising);
}

/// Returns the fraction of the step, in (0, 1], at which g is 0, to `width`, by Alefeld, Potra and
/// Shi's algorithm 748. `g(fraction)` returns nullopt where the shorter step has no solution; the
/// result is then 1.
template <class Function>
double zero_fraction(const Function& g, double before, double after, double width) {
  if (after == 0) return 1;
  struct NoState {};
  double best = 1, least = std::abs(after);
  const auto at = [&](double fraction) {
    const std::optional<double> value = g(fraction);
    if (!value || std::isnan(*value)) throw NoState();
    if (std::abs(*value) < least) {
      least = std::abs(*value);
      best = fraction;
    }
    return *value;
  };
  const auto close = [width](double a, double b) { return b - a <= width; };
  std::uintmax_t most = 100;
  try {
    boost::math::tools::toms748_solve(at, 0.0, 1.0, before, after, close, most);
  } catch (const NoState&) {
    return 1;
  }
  return best;
}

}  // namespace

Events::Events(const Plan& plan, const Simulation& start) : plan_(plan) {
  for (const EventDescription& event : plan.what.events) {
    Function& function = functions_.emplace_back();
    add(start, event.field, event.coefficients, function);
    for (const LinearTerm& more : event.plus) add(start, more.field, more.coefficients, function);
  }
}

void Events::add(const Simulation& start, const std::string& field,
                 const std::vector<double>& coefficients, Function& to) {
  const std::size_t index = find_field(start.fields(), field).value();
  auto read = std::ranges::find(fields_, index, &Read::index);
  if (read == fields_.end()) {
    fields_.push_back({index, std::vector<double>(coefficients.size())});
    read = fields_.end() - 1;
  }
  to.terms.push_back({static_cast<std::size_t>(read - fields_.begin()), &coefficients});
  if (!field_at(start.fields(), index).angles) return;
  for (const double c : {coefficients[0], coefficients[2]})
    if (c != 0) to.period = 2 * std::numbers::pi_v<long double> * std::abs(c);
}

double Events::sum(std::size_t event) const {
  const Function& function = functions_[event];
  long double g = 0;
  for (const Term& term : function.terms) {
    const auto& numbers = fields_[term.field].numbers;
    const auto& coefficients = *term.coefficients;
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (coefficients[i] != 0) g += static_cast<long double>(coefficients[i]) * numbers[i];
  }
  g -= plan_.what.events[event].level;
  return static_cast<double>(function.period > 0 ? std::remainder(g, function.period) : g);
}

double Events::value(const Simulation& now, std::size_t event) {
  for (const Term& term : functions_[event].terms) {
    Read& read = fields_[term.field];
    now.write(read.index, read.numbers);
  }
  return sum(event);
}

bool Events::waits(const Member& member) const {
  for (std::size_t e = 0; e < functions_.size(); ++e)
    if (waits(member, e)) return true;
  return false;
}

std::optional<double> Events::slope(Member& member, std::size_t event, std::int64_t k,
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
  const auto period = static_cast<double>(functions_[event].period);
  double sum = 0;
  for (int j = 1; j <= 3; ++j) {
    double g[2];
    for (const int side : {0, 1}) {
      const double away = side == 0 ? -j * delta : j * delta;
      const Simulation* now = member.between().at(k, fraction + away, there, stop);
      if (now == nullptr) return std::nullopt;
      g[side] = value(*now, event);
    }
    const double change = g[1] - g[0];
    sum += of_step[j - 1] * (period > 0 ? std::remainder(change, period) : change);
  }
  return sum / delta;
}

void Events::values(Member& member, std::int64_t k, const Simulation& now, std::vector<double>& g,
                    const std::stop_token& stop) {
  for (Read& read : fields_) now.write(read.index, read.numbers);
  g.resize(functions_.size());
  for (std::size_t e = 0; e < g.size(); ++e) g[e] = sum(e);
  std::vector<double> saved;
  for (std::size_t e = 0; e < g.size(); ++e) {
    if (!plan_.what.events[e].extremum || !waits(member, e)) continue;
    saved.resize(now.saved_size());
    now.save(saved);
    g[e] = slope(member, e, k, 0, saved, stop)
               .value_or(std::numeric_limits<double>::quiet_NaN());  // at which no event is
  }
}

std::vector<Events::Zero> Events::zeros(Member& member, const LastStep& step,
                                        const std::stop_token& stop) {
  std::vector<Zero> found;
  constexpr double width_of_extremum = 0x1p-46;  // below the error of g'
  values(member, step.to, step.now, g_, stop);
  for (std::size_t e = 0; e < g_.size(); ++e) {
    const EventDescription& event = plan_.what.events[e];
    if (!waits(member, e) || !crosses(member.g[e], g_[e], event.direction)) continue;
    const auto period = static_cast<double>(event.extremum ? 0 : functions_[e].period);
    if (period > 0 && std::abs(g_[e] - member.g[e]) >= period / 2) continue;
    const auto g = [&](double fraction) -> std::optional<double> {
      if (event.extremum) return slope(member, e, step.to - 1, fraction, step.before, stop);
      const Simulation* now = member.between().at(step.to - 1, fraction, step.before, stop);
      if (now == nullptr) return std::nullopt;
      return value(*now, e);
    };
    const double width = event.extremum ? width_of_extremum : 0x1p-52;
    found.push_back({e, plan_.discrete ? 1 : zero_fraction(g, member.g[e], g_[e], width)});
  }
  member.g = g_;
  std::ranges::sort(found, {}, [](const Zero& z) { return std::pair(z.fraction, z.event); });
  return found;
}

std::optional<Events::Terminal> Events::report(Member& member, const LastStep& step,
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
