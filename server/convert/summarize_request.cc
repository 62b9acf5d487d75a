#include "server/convert/summarize_answer.h"

#include <algorithm>
#include <utility>

#include "server/convert/errors.h"
#include "server/convert/faults.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

static_assert(static_cast<int>(Direction::falling) == v1::DIRECTION_FALLING);

/// The most fields that a request may name: more than any system has.
constexpr std::size_t max_fields = 64;

constexpr std::pair<v1::Statistic, Statistic> statistics[] = {
    {v1::STATISTIC_LAST, Statistic::last},   {v1::STATISTIC_MIN, Statistic::min},
    {v1::STATISTIC_MAX, Statistic::max},     {v1::STATISTIC_MEAN, Statistic::mean},
    {v1::STATISTIC_RMS, Statistic::rms},     {v1::STATISTIC_SIGN_CHANGES, Statistic::sign_changes},
    {v1::STATISTIC_DRIFT, Statistic::drift},
};

void read(const v1::Quantity& from, const Path& path, Quantity& to, Faults& faults) {
  to.name = from.name();
  std::size_t read = 0;
  for (const int given : from.statistics()) {
    if (++read % 4096 == 0) stop_point();
    const auto* known =
        std::ranges::find(statistics, given, [](const auto& s) { return int{s.first}; });
    if (known != std::end(statistics))
      to.statistics.push_back(known->second);
    else
      faults.add(Path(path, "statistics"),
                 [&] { return std::pair(std::to_string(given), "must be a Statistic"); });
  }
  to.quantiles.assign(from.quantiles().begin(), from.quantiles().end());
  to.edges.assign(from.edges().begin(), from.edges().end());
  to.over_members = from.over_members();
}

void read(const v1::Event& from, const Path& path, EventDescription& to, Faults& faults) {
  to.field = from.field();
  to.coefficients.assign(from.coefficients().begin(), from.coefficients().end());
  if (faults.at_most(Path(path, "plus"), from.plus_size(), max_fields))
    for (const v1::LinearTerm& term : from.plus())
      to.plus.push_back({term.field(), {term.coefficients().begin(), term.coefficients().end()}});
  to.level = from.level();
  to.limit = from.limit();
  to.terminal = from.terminal();
  to.extremum = from.extremum();
  to.direction = static_cast<Direction>(from.direction());
  if (!v1::Direction_IsValid(from.direction()))
    faults.add(Path(path, "direction"), std::to_string(int{from.direction()}),
               "must be a Direction");
}

}  // namespace

SummaryDescription from_proto(const v1::SummarizeRequest& request) {
  SummaryDescription what;
  Faults faults(in_the_request);
  what.from = request.from();
  what.to = request.to();
  what.every = std::max<std::int64_t>(request.every(), 1);
  const Path quantities("quantities"), events("events");
  if (faults.at_most("quantities", request.quantities_size(), Summary::max_quantities))
    for (int i = 0; i < request.quantities_size(); ++i)
      read(request.quantities(i), Path(quantities, i), what.quantities.emplace_back(), faults);
  if (faults.at_most("events", request.events_size(), Summary::max_events))
    for (int i = 0; i < request.events_size(); ++i)
      read(request.events(i), Path(events, i), what.events.emplace_back(), faults);
  faults.at_most("fields", request.fields_size(), max_fields);
  faults.at_most("times", request.times_size(), Summary::max_times);
  check(faults);
  what.times.assign(request.times().begin(), request.times().end());
  what.fields.assign(request.fields().begin(), request.fields().end());
  return what;
}

}  // namespace stiefel::server
