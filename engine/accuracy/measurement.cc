#include "engine/accuracy/measurement.h"
#include "engine/motion/invariant_list.h"
#include "stiefel/diagnosis.h"

#include <ctime>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "stiefel/catalogue.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

/// Number of coarse steps at equal distances.
constexpr int evenly = 8;
/// The most dense samples that are not all steps.
constexpr double most_dense_steps = 512;
/// Largest N with Manakov's coefficients, which cost N⁵ operations at every sample.
constexpr int largest_with_manakov = 8;
/// Work between two checks for a stop request.
constexpr double slice_work = 5e6;

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::vector<std::string> watched(const Scene& scene) {
  std::vector<std::string> families;
  // An empty list: all cheap families.
  if (scene.dimension() <= largest_with_manakov) return families;
  for (const auto& invariant : catalogue().system(scene.system())->invariants)
    if (invariant.name != family::manakov && invariant.name != family::lax)
      families.emplace_back(invariant.name);
  return families;
}

class InvariantWatch {
 public:
  InvariantWatch(const Scene& scene, const Simulation& start)
      : only_(watched(scene)), before_(only_) {
    start.invariants(before_);
  }
  void look(const Simulation& now, Run& run) const {
    InvariantList after(only_);
    now.invariants(after);
    for (std::size_t i = 0; i < std::min(before_.entries().size(), after.entries().size()); ++i) {
      const auto& start = before_.entries()[i];
      const double drift = drift_of(start.value, after.entries()[i].value, start.scale);
      if (drift > run.drift || run.drift_of.empty()) {
        run.drift = drift;
        run.drift_of = start.name;
      }
    }
    if (const auto defect = now.orthogonality(); defect && *defect > run.drift) {
      run.drift = *defect;
      run.drift_of = family::orthogonality;
    }
  }

 private:
  std::vector<std::string> only_;
  InvariantList before_;
};

}  // namespace

std::int64_t steps_to(double horizon, double step) {
  const double steps = horizon / std::abs(step);
  const double whole = std::round(steps);
  const double up = std::abs(steps - whole) <= 1e-9 * whole ? whole : std::ceil(steps);
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::min(up, 1e15)));
}

namespace {

/// Returns the coarse steps and `count` more; all steps of a short horizon.
std::vector<std::int64_t> dense_steps(std::int64_t horizon_steps, std::size_t count) {
  std::set<std::int64_t> wanted;
  for (std::int64_t k = horizon_steps; k >= 1; k /= 2) wanted.insert(k);
  const auto place = [&](double part) {
    const auto step = static_cast<std::int64_t>(part * static_cast<double>(horizon_steps));
    wanted.insert(std::clamp<std::int64_t>(step, 1, horizon_steps));
  };
  for (int i = 1; i <= evenly; ++i) place(static_cast<double>(i) / evenly);
  if (static_cast<double>(horizon_steps) <= static_cast<double>(count))
    for (std::int64_t k = 1; k <= horizon_steps; ++k) wanted.insert(k);
  else
    for (std::size_t i = 0; i < count; ++i) {
      const double within = std::fmod(std::numbers::phi * static_cast<double>(i + 1), 1);
      place((static_cast<double>(i) + within) / static_cast<double>(count));
    }
  return {wanted.begin(), wanted.end()};
}

/// Returns how many dense samples the budget and `most_bytes` allow: `steps`, or fewer for which a
/// quarter of the budget suffices.
std::size_t affordable_samples(const Scene& scene, const Reference& reference, std::int64_t steps,
                               double all_work, double budget, double most_bytes) {
  if (all_work <= budget && static_cast<double>(steps) * sample_bytes(scene) <= most_bytes)
    return static_cast<std::size_t>(steps);
  const double count = std::min(
      {most_dense_steps, budget / 4 / reference.answer_work(), most_bytes / sample_bytes(scene)});
  // A power of two: references of several motions then have the same samples.
  return std::bit_floor(static_cast<std::size_t>(std::max(0.0, count)));
}

}  // namespace

double sample_bytes(const Scene& scene) {
  constexpr double of_blocks = 128;
  const auto numbers = std::max({scene.Q().size(), scene.block("q").size(), scene.M().size()});
  return of_blocks + 2 * sizeof(long double) * static_cast<double>(numbers);
}

double comparison_work(const Scene& scene) {
  constexpr double of_state = 3e3, of_number = 50;
  return of_state + of_number * static_cast<double>(scene.Q().size() + scene.inertia().size());
}

Samples take_samples(const Scene& scene, std::int64_t steps, Density density,
                     const ReferenceNeed& need, const std::stop_token& stop, double most_bytes) {
  Samples samples;
  const auto reference =
      unless_stopped(stop, [&] { return make_reference(scene, need); }).value_or(nullptr);
  if (!reference) return samples;
  samples.reference = reference->description();
  std::size_t dense = 0;
  if (density == Density::dense) {
    samples.all_work =
        reference->predicted_work(scene.time(steps), stop).value_or(reference->work()) +
        static_cast<double>(steps) * reference->answer_work();
    dense = affordable_samples(scene, *reference, steps, samples.all_work, need.budget, most_bytes);
  }
  const auto wanted = dense_steps(steps, dense);
  samples.steps.reserve(wanted.size());
  samples.answers.reserve(wanted.size());
  for (const std::int64_t step : wanted) {
    auto answer = unless_stopped(stop, [&] {
                    return reference->at(scene.time(step), stop);
                  }).value_or(std::nullopt);
    if (!answer) break;
    samples.steps.push_back(step);
    samples.answers.push_back(*std::move(answer));
  }
  samples.work = reference->work();
  if (samples.steps.empty() && !stop.stop_requested())
    samples.first_price =
        reference->predicted_work(scene.time(*wanted.begin()), stop).value_or(samples.work);
  return samples;
}

double Run::largest_error(std::size_t count) const {
  double largest = 0;
  for (std::size_t i = 0; i < std::min(count, errors.size()); ++i)
    largest = std::max(largest, errors[i].largest());
  return largest;
}

namespace {

void run_within(const StopScope& cap, const Scene& scene, double weight, const Samples& samples,
                const RunBounds& bounds, Run& out) {
  const auto now = make_simulation(scene);
  const bool jumps = now->direct() && bounds.watch == Watch::errors;
  const double comparison = comparison_work(scene);
  const auto count = [&] {
    out.steps = now->step();
    const double computed = weight * static_cast<double>(now->map_steps());
    out.work = jumps ? weight * static_cast<double>(out.steps) : computed;
    out.spent =
        std::max(computed, cap.operations()) + comparison * static_cast<double>(out.errors.size());
  };
  std::optional<InvariantWatch> invariants;
  if (bounds.watch == Watch::errors_and_invariants) invariants.emplace(scene, *now);
  // Where time is measured a closed form computes every state, because methods are compared by the
  // cost of all states.
  const double steps = now->direct() ? 1 : slice_work / (weight * scene.substeps());
  const auto slice = jumps ? std::numeric_limits<std::int64_t>::max()
                           : static_cast<std::int64_t>(std::max(1.0, std::floor(steps)));
  const auto go_to = [&](std::int64_t step) {
    const double start = thread_seconds();
    while (now->step() < step && out.status.reached()) {
      stop_point();
      out.status = out.spent > bounds.most_work ? RunStatus{Outcome::cancelled, std::nullopt}
                                                : now->advance(std::min(slice, step - now->step()));
      count();
    }
    out.cpu_seconds += thread_seconds() - start;
    return out.status.reached();
  };
  if (bounds.watch == Watch::time) {
    go_to(bounds.to);
    return;
  }
  for (const std::int64_t step : bounds.compared) {
    if (step > bounds.to || !go_to(step)) break;
    const auto sample = std::ranges::lower_bound(samples.steps, step) - samples.steps.begin();
    const auto& exact = samples.answers[static_cast<std::size_t>(sample)].state;
    out.errors.push_back(error_of(read_motion(scene, *now), exact));
    if (invariants) invariants->look(*now, out);
    if (out.errors.back().largest() > bounds.most_error) break;
  }
}

}  // namespace

Run run(const Scene& scene, double weight, const Samples& samples, const RunBounds& bounds) {
  Run out;
  {
    const StopScope cap(bounds.stop, bounds.most_work);
    try {
      run_within(cap, scene, weight, samples, bounds, out);
    } catch (const Stopped&) {
      if (!bounds.stop.stop_requested() && !cap.used_up()) throw;
      out.status = RunStatus{Outcome::cancelled, std::nullopt};
    }
  }
  // Throws if an outer scope requested the stop.
  if (out.status.outcome == Outcome::cancelled) stop_point();
  return out;
}

std::int64_t affordable_steps(const std::vector<std::int64_t>& steps, double step_work,
                              double work) {
  const auto affordable = [&](std::int64_t step) {
    return static_cast<double>(step) * step_work <= work;
  };
  const auto longest = std::ranges::find_if(steps.rbegin(), steps.rend(), affordable);
  return longest == steps.rend() ? steps.front() : *longest;
}

}  // namespace stiefel
