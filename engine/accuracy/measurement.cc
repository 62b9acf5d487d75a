#include "engine/accuracy/measurement.h"

#include <ctime>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "engine/motion/invariant_list.h"
#include "stiefel/catalogue.h"
#include "stiefel/diagnosis.h"
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

/// Returns the coarse steps and `count` more; all steps of a short horizon.
std::vector<std::int64_t> sampled_steps(std::int64_t horizon_steps, double count) {
  std::set<std::int64_t> wanted;
  for (std::int64_t k = horizon_steps; k >= 1; k /= 2) wanted.insert(k);
  const auto place = [&](double part) {
    const auto step = static_cast<std::int64_t>(part * static_cast<double>(horizon_steps));
    wanted.insert(std::clamp<std::int64_t>(step, 1, horizon_steps));
  };
  for (int i = 1; i <= evenly; ++i) place(static_cast<double>(i) / evenly);
  if (static_cast<double>(horizon_steps) <= count)
    for (std::int64_t k = 1; k <= horizon_steps; ++k) wanted.insert(k);
  else
    for (double i = 0; i + 1 <= count; ++i)
      place((i + std::fmod(std::numbers::phi * (i + 1), 1)) / std::floor(count));
  return {wanted.begin(), wanted.end()};
}

/// The families of invariants whose drift is watched; an empty list for all cheap ones.
std::vector<std::string> watched(const Scene& scene) {
  std::vector<std::string> families;
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
    const auto take = [&run](double drift, std::string_view of) {
      if (!(drift > run.drift) && !run.drift_of.empty()) return;
      run.drift = drift;
      run.drift_of = of;
    };
    for (std::size_t i = 0; i < std::min(before_.entries().size(), after.entries().size()); ++i) {
      const auto& start = before_.entries()[i];
      take(drift_of(start.value, after.entries()[i].value, start.scale), start.name);
    }
    if (const auto defect = now.orthogonality(); defect && *defect > run.drift)
      take(*defect, family::orthogonality);
  }

 private:
  std::vector<std::string> only_;
  InvariantList before_;
};

/// Merges the run of one more motion into that of the motions before it.
void take_in(const Run& one, Run& all) {
  all.errors.resize(std::min(all.errors.size(), one.errors.size()));
  for (std::size_t i = 0; i < all.errors.size(); ++i) {
    auto& [attitude, momentum] = all.errors[i];
    if (one.errors[i].attitude) attitude = std::max(attitude.value_or(0), *one.errors[i].attitude);
    momentum = std::max(momentum, one.errors[i].momentum);
  }
  all.status = one.status;
  all.steps = std::min(all.steps, one.steps);
  all.work += one.work;
  all.spent += one.spent;
  all.cpu_seconds += one.cpu_seconds;
  if (all.drift_of.empty() || one.drift > all.drift) {
    all.drift = one.drift;
    all.drift_of = one.drift_of;
  }
}

/// Runs motion `b` of the samples; `scope` has the bounds of the work.
void run_one(const Scene& scene, std::size_t b, double weight, const Samples& samples,
             const RunBounds& bounds, const StopScope& scope, Run& out) {
  const auto now = make_simulation(scene);
  const bool jumps = now->direct() && bounds.watch == Watch::errors;
  const auto count = [&] {
    out.steps = now->step();
    const double computed = weight * static_cast<double>(now->map_steps());
    out.work = jumps ? weight * static_cast<double>(out.steps) : computed;
    out.spent = std::max(computed, scope.operations()) +
                comparison_work(scene) * static_cast<double>(out.errors.size());
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
  for (std::size_t i = 0; i < samples.steps.size(); ++i) {
    if (samples.steps[i] > bounds.to || !go_to(samples.steps[i])) break;
    out.errors.push_back(error_of(read_motion(scene, *now), samples.states[i][b]));
    if (invariants) invariants->look(*now, out);
    if (out.errors.back().largest() > bounds.most_error) break;
  }
}

}  // namespace

std::int64_t steps_to(double horizon, double step) {
  const double steps = horizon / std::abs(step);
  const double whole = std::round(steps);
  const double up = std::abs(steps - whole) <= 1e-9 * whole ? whole : std::ceil(steps);
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::min(up, 1e15)));
}

double sample_bytes(const Scene& scene) {
  constexpr double of_blocks = 128;
  const auto numbers = std::max({scene.Q().size(), scene.block("q").size(), scene.M().size()});
  return of_blocks + 2 * sizeof(long double) * static_cast<double>(numbers);
}

double comparison_work(const Scene& scene) {
  constexpr double of_state = 3e3, of_number = 50;
  return of_state + of_number * static_cast<double>(scene.Q().size() + scene.inertia().size());
}

std::vector<double> Run::course() const {
  std::vector<double> largest;
  for (const MotionError& error : errors)
    largest.push_back(std::max(largest.empty() ? 0 : largest.back(), error.largest()));
  return largest;
}

bool MeasuredMotions::take(const MethodDescription& method) const {
  return std::ranges::all_of(scenes_, [&](const Scene& scene) {
    stop_point();
    return scene.with(method).has_value();
  });
}

void MeasuredMotions::solve_references(std::int64_t steps, Density density,
                                       const ReferenceNeed& need, const std::stop_token& stop) {
  samples_ = {};
  const auto motions = static_cast<double>(count()), all = static_cast<double>(steps);
  std::vector<std::unique_ptr<Reference>> references;
  double answer_work = 0;
  std::vector<MotionState> states;
  double error = 0;
  const auto answer = [&](std::size_t b, std::int64_t step) {
    auto at = references[b]->at(front().time(step), stop);
    if (!at) return false;
    states.push_back(std::move(at->state));
    error = std::max(error, at->error);
    return true;
  };
  const auto solve = [&] {
    // The first sample of every motion. Where one has none the other references are not needed.
    for (std::size_t b = 0; b < count(); ++b) {
      auto made = make_reference(scenes_[b], {need.time, need.budget / motions, need.quadruple});
      if (!made) return;
      Reference& reference = *references.emplace_back(std::move(made));
      if (samples_.reference.find(reference.description()) == std::string::npos)
        samples_.reference += (b > 0 ? " or " : "") + reference.description();
      if (density == Density::dense)
        samples_.all_work +=
            reference.predicted_work(front().time(steps), stop) + all * reference.answer_work();
      answer_work += reference.answer_work();
      if (answer(b, 1)) continue;
      if (!stop.stop_requested())
        samples_.first_price = motions * reference.predicted_work(front().time(1), stop);
      return;
    }
    const double bytes = motions * sample_bytes(front());
    double dense = 0;
    if (density == Density::dense)
      dense = samples_.all_work <= need.budget && all * bytes <= Choice::most_sample_bytes
                  ? all
                  : std::min({most_dense_steps, need.budget / 4 / answer_work,
                              Choice::most_sample_bytes / bytes});
    for (const std::int64_t step : sampled_steps(steps, dense)) {
      for (std::size_t b = states.size(); b < count(); ++b)
        if (!answer(b, step)) return;
      samples_.steps.push_back(step);
      samples_.states.push_back(std::exchange(states, {}));
      samples_.errors.push_back(error);
    }
  };
  unless_stopped(stop, [&] { return solve(), true; });
  for (const auto& reference : references) samples_.work += reference->work();
}

Run MeasuredMotions::run(const MethodDescription& method, double weight, const RunBounds& bounds,
                         std::size_t first) const {
  const double weight_of_one = weight / static_cast<double>(count());
  Run all;
  double largest = -1;
  for (std::size_t k = 0; k < count(); ++k) {
    const std::size_t b = k == 0 ? first : k <= first ? k - 1 : k;
    RunBounds left = bounds;
    left.most_work -= all.spent;
    Run one;
    {
      const StopScope scope(left.stop, left.most_work);
      try {
        run_one(scenes_[b].with(method).value(), b, weight_of_one, samples_, left, scope, one);
      } catch (const Stopped&) {
        if (!left.stop.stop_requested() && !scope.used_up()) throw;
        one.status = RunStatus{Outcome::cancelled, std::nullopt};
      }
    }
    // Throws if an outer scope requested the stop.
    if (one.status.outcome == Outcome::cancelled) stop_point();
    const double error = one.largest_error();
    if (k == 0)
      all = std::move(one);
    else
      take_in(one, all);
    if (error > largest) {
      largest = error;
      all.member = b;
    }
    if (!all.status.reached() && count() > 1) all.status.member = static_cast<std::int64_t>(b);
    if (!all.status.reached() || error > bounds.most_error) break;
  }
  return all;
}

}  // namespace stiefel
