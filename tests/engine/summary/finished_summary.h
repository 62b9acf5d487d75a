#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "stiefel/scene.h"
#include "stiefel/simulation.h"
#include "stiefel/summary.h"
#include "tests/support/scenes/resolved.h"

/// Summaries as the tests run and compare them.
namespace stiefel::testing {

inline std::unique_ptr<Summary> prepare(const Scene& scene, SummaryDescription what) {
  auto summary = Summary::prepare(scene, std::move(what));
  if (!summary) throw std::logic_error(summary.error().front().rule);
  return *std::move(summary);
}

/// All of a summary as bytes, and its events and states.
struct Done {
  std::vector<SummaryArray> statistics;
  std::vector<Event> events;
  std::vector<StateAtTime> states;
  RunStatus status;

  const SummaryArray& operator[](std::string_view name) const {
    return *std::ranges::find(statistics, name, &SummaryArray::name);
  }
  void take(Summary& summary) {
    std::ranges::move(summary.take_events(), std::back_inserter(events));
    std::ranges::move(summary.take_states(), std::back_inserter(states));
  }
  std::vector<std::uint64_t> bits() const {
    std::vector<std::uint64_t> all;
    const auto number = [&](double x) { all.push_back(std::bit_cast<std::uint64_t>(x)); };
    for (const auto& array : statistics) {
      std::ranges::for_each(array.numbers, number);
      for (const auto count : array.counts) all.push_back(static_cast<std::uint64_t>(count));
    }
    for (const Event& event : events) {
      all.insert(all.end(), {event.event, static_cast<std::uint64_t>(event.step), event.member});
      number(event.fraction);
      number(event.time);
      std::ranges::for_each(event.fields, number);
    }
    for (const StateAtTime& state : states) {
      all.push_back(static_cast<std::uint64_t>(state.step));
      std::ranges::for_each(state.fields, number);
    }
    return all;
  }
};

inline Done finish(Summary& summary, std::int64_t steps = 1000) {
  Done done;
  while (!summary.done()) {
    summary.advance(steps, summary.description().to);
    done.take(summary);
  }
  done.statistics = summary.statistics();
  done.status = summary.status();
  return done;
}

inline Done run(const Scene& scene, const SummaryDescription& what, std::int64_t steps = 1000) {
  return finish(*prepare(scene, what), steps);
}

inline const std::vector<Statistic> every_statistic = {
    Statistic::last, Statistic::min,          Statistic::max,  Statistic::mean,
    Statistic::rms,  Statistic::sign_changes, Statistic::drift};

inline SummaryDescription everything(std::int64_t from, std::int64_t to, std::int64_t every) {
  SummaryDescription what{.from = from, .to = to, .every = every};
  what.quantities = {{"energy", every_statistic, {0, 0.3, 1}, {}},
                     {"M", every_statistic, {0.5}, {-2, -0.5, 0, 0.5, 2}},
                     {"casimirs", {Statistic::drift, Statistic::last}, {}, {}},
                     {"quaternion", {Statistic::last}, {}, {}}};
  return what;
}

/// m_2 of a body.
inline EventDescription crossing(Direction direction = Direction::both) {
  EventDescription event{.field = "M", .coefficients = std::vector<double>(9, 0)};
  event.coefficients[2] = 1;
  event.direction = direction;
  return event;
}

/// `what` with two events and six times, some of them between two steps.
inline SummaryDescription with_all(SummaryDescription what, double step) {
  what.events = {crossing(), crossing(Direction::rising)};
  what.events[1].limit = 2;
  for (const double k : {5.0, 5.25, 17.5, 17.75, 200.0, 300.125}) what.times.push_back(k * step);
  return what;
}

/// The values of a field at the samples.
inline std::vector<std::vector<double>> samples(const Scene& scene, std::string_view name,
                                                const SummaryDescription& what) {
  const auto simulation = make_simulation(scene);
  simulation->advance(what.from);
  std::vector<std::vector<double>> all;
  for (std::int64_t step = what.from;; step = std::min(step + what.every, what.to)) {
    simulation->advance(step - simulation->step());
    const RowMatrix value = simulation->get(name);
    all.emplace_back(value.data(), value.data() + value.size());
    if (step == what.to) return all;
  }
}

}  // namespace stiefel::testing
