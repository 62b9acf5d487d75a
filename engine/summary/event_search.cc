#include "engine/summary/event_search.h"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

namespace stiefel {
namespace {

struct NoState {};

}  // namespace

EventFunctions::EventFunctions(const std::vector<EventDescription>& events,
                               const Simulation& start) {
  for (const EventDescription& event : events) {
    Function& function = functions_.emplace_back(Function{{}, event.level});
    function.terms.push_back(term(start, event.field, event.coefficients));
    for (const LinearTerm& more : event.plus)
      function.terms.push_back(term(start, more.field, more.coefficients));
  }
}

EventFunctions::Term EventFunctions::term(const Simulation& start, const std::string& field,
                                          const std::vector<double>& coefficients) {
  const auto found = std::ranges::find(start.fields(), field, &Field::name);
  const auto index = static_cast<std::size_t>(found - start.fields().begin());
  auto read = std::ranges::find(fields_, index, &Read::index);
  if (read == fields_.end()) {
    fields_.push_back({index, std::vector<double>(coefficients.size())});
    read = fields_.end() - 1;
  }
  return {static_cast<std::size_t>(read - fields_.begin()), &coefficients};
}

double EventFunctions::sum(const Function& function) const {
  long double g = 0;
  for (const Term& term : function.terms) {
    const auto& numbers = fields_[term.field].numbers;
    const auto& coefficients = *term.coefficients;
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (coefficients[i] != 0) g += static_cast<long double>(coefficients[i]) * numbers[i];
  }
  return static_cast<double>(g - function.level);
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
  switch (direction) {
    case Direction::rising:
      return rising;
    case Direction::falling:
      return falling;
    default:
      return rising || falling;
  }
}

double zero_fraction(const std::function<std::optional<double>(double)>& g, double before,
                     double after) {
  if (after == 0) return 1;
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
  const auto to_rounding = [](double a, double b) { return b - a <= 0x1p-52; };
  std::uintmax_t most = 100;
  try {
    boost::math::tools::toms748_solve(at, 0.0, 1.0, before, after, to_rounding, most);
  } catch (const NoState&) {
    return 1;
  }
  return best;
}

}  // namespace stiefel
