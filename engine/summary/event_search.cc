#include "engine/summary/event_search.h"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <numbers>

namespace stiefel {
EventFunctions::EventFunctions(const std::vector<EventDescription>& events,
                               const Simulation& start) {
  for (const EventDescription& event : events) {
    Function& function = functions_.emplace_back(Function{{}, event.level});
    add(start, event.field, event.coefficients, function);
    for (const LinearTerm& more : event.plus) add(start, more.field, more.coefficients, function);
  }
}

void EventFunctions::add(const Simulation& start, const std::string& field,
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

double EventFunctions::sum(const Function& function) const {
  long double g = 0;
  for (const Term& term : function.terms) {
    const auto& numbers = fields_[term.field].numbers;
    const auto& coefficients = *term.coefficients;
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (coefficients[i] != 0) g += static_cast<long double>(coefficients[i]) * numbers[i];
  }
  g -= function.level;
  return static_cast<double>(function.period > 0 ? std::remainder(g, function.period) : g);
}

void EventFunctions::values(const Simulation& now, std::vector<double>& g) {
  for (Read& read : fields_) now.write(read.index, read.numbers);
  g.resize(functions_.size());
  for (std::size_t i = 0; i < functions_.size(); ++i) g[i] = sum(functions_[i]);
}

double EventFunctions::value(const Simulation& now, std::size_t event) {
  for (const Term& term : functions_[event].terms) {
    Read& read = fields_[term.field];
    now.write(read.index, read.numbers);
  }
  return sum(functions_[event]);
}

bool crosses(double before, double after, Direction direction) {
  const bool rising = before < 0 && after >= 0, falling = before > 0 && after <= 0;
  return (rising && direction != Direction::falling) || (falling && direction != Direction::rising);
}

double zero_fraction(const std::function<std::optional<double>(double)>& g, double before,
                     double after, double width) {
  if (after == 0) return 1;
  struct NoState {};
  double best = 1, least = std::abs(after);
  const auto at = [&](double fraction) {
    const auto value = g(fraction);
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

}  // namespace stiefel
