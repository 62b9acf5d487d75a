#include "server/convert/summary/request.h"

#include <algorithm>
#include <utility>

#include "server/convert/errors.h"

namespace stiefel::server {
namespace {

constexpr std::pair<v1::Statistic, Statistic> statistics[] = {
    {v1::STATISTIC_LAST, Statistic::last},   {v1::STATISTIC_MIN, Statistic::min},
    {v1::STATISTIC_MAX, Statistic::max},     {v1::STATISTIC_MEAN, Statistic::mean},
    {v1::STATISTIC_RMS, Statistic::rms},     {v1::STATISTIC_SIGN_CHANGES, Statistic::sign_changes},
    {v1::STATISTIC_DRIFT, Statistic::drift},
};

std::string path(const char* list, int i, const char* field) {
  return std::string(list) + "[" + std::to_string(i) + "]." + field;
}

void read(const v1::Quantity& from, int i, Quantity& to, Violations& violations) {
  to.name = from.name();
  for (const int given : from.statistics()) {
    const auto* known =
        std::ranges::find(statistics, given, [](const auto& s) { return int{s.first}; });
    if (known != std::end(statistics))
      to.statistics.push_back(known->second);
    else
      violations.push_back(
          {path("quantities", i, "statistics"), std::to_string(given), "must be a Statistic"});
  }
  to.quantiles.assign(from.quantiles().begin(), from.quantiles().end());
  to.edges.assign(from.edges().begin(), from.edges().end());
  to.over_members = from.over_members();
}

void read(const v1::Event& from, int i, EventDescription& to, Violations& violations) {
  to.field = from.field();
  to.coefficients.assign(from.coefficients().begin(), from.coefficients().end());
  to.level = from.level();
  to.limit = from.limit();
  to.terminal = from.terminal();
  switch (from.direction()) {
    case v1::DIRECTION_UNSPECIFIED:
      to.direction = Direction::both;
      break;
    case v1::DIRECTION_RISING:
      to.direction = Direction::rising;
      break;
    case v1::DIRECTION_FALLING:
      to.direction = Direction::falling;
      break;
    default:
      violations.push_back({path("events", i, "direction"), std::to_string(int{from.direction()}),
                            "must be a Direction"});
  }
}

}  // namespace

OrStatus<SummaryDescription> from_proto(const v1::SummarizeRequest& request) {
  SummaryDescription what;
  Violations violations;
  what.from = request.from();
  what.to = request.to();
  what.every = std::max<std::int64_t>(request.every(), 1);
  const auto few = [&](const char* list, int count, std::size_t most) {
    if (std::cmp_less_equal(count, most)) return true;
    violations.push_back({list, std::to_string(count), "must be at most " + std::to_string(most)});
    return false;
  };
  if (few("quantities", request.quantities_size(), Summary::max_quantities))
    for (int i = 0; i < request.quantities_size(); ++i)
      read(request.quantities(i), i, what.quantities.emplace_back(), violations);
  if (few("events", request.events_size(), Summary::max_events))
    for (int i = 0; i < request.events_size(); ++i)
      read(request.events(i), i, what.events.emplace_back(), violations);
  if (!violations.empty()) return std::unexpected(errors::invalid(violations));
  what.times.assign(request.times().begin(), request.times().end());
  what.fields.assign(request.fields().begin(), request.fields().end());
  return what;
}

}  // namespace stiefel::server
