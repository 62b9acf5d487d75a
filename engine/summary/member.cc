#include "engine/summary/member.h"

#include <algorithm>
#include <cmath>

#include "engine/motion/observed_simulation.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {
namespace {

/// A smaller part of a step changes no number of a state by more than its rounding: a step turns a
/// body by less than 2³² radians, and blocks move at most 2³² times as fast as frames turn. A step
/// this short would lose its own square to underflow.
constexpr double least_in_double = 0x1p-120, least_in_float = 0x1p-60;

/// Returns the scene with a step of any size.
Scene with_step(const Scene& scene, double step, int substeps) {
  SceneDraft draft(scene);
  draft.given().step = step;
  draft.given().method->substeps = substeps;
  return draft.take().value();
}

}  // namespace

PartialStep::PartialStep(const Scene& scene)
    : scene_(scene), simulation_(make_simulation(scene)), direct_(simulation_->direct()) {}

const Simulation* PartialStep::at(std::int64_t k, double fraction, std::span<const double> saved,
                                  const std::stop_token& stop) {
  if (direct_) {
    const long double steps = static_cast<long double>(k) + fraction;
    const auto time = static_cast<double>(steps * scene_.step());
    return at_first_of({&time, 1}, stop);
  }
  if (stop.stop_requested()) return nullptr;
  const bool moves = std::abs(fraction) >= (scene_.in_float() ? least_in_float : least_in_double);
  simulation_ = make_simulation(
      moves ? with_step(scene_, fraction * scene_.step(), scene_.substeps()) : scene_);
  simulation_->restore(0, saved);
  if (moves && !simulation_->advance(1, stop).reached()) return nullptr;
  return simulation_.get();
}

const Simulation* PartialStep::at_first_of(std::span<const double> times,
                                           const std::stop_token& stop) {
  if (stop.stop_requested()) return nullptr;
  auto& motion = dynamic_cast<ObservedSimulation&>(*simulation_);
  return motion.move_to(times, stop).reached() ? simulation_.get() : nullptr;
}

Member::Member(const Scene& all, std::size_t number, const Plan& plan, std::span<double> values)
    : index(number), last(values), events(plan.what.events.size(), 0), all_(&all) {
  for (std::size_t q = 0; plan.reads_on_the_way && q < plan.reads.size(); ++q) {
    const Quantity& quantity = plan.what.quantities[q];
    const std::size_t size = plan.reads[q].size;
    const auto kept = static_cast<std::size_t>(quantity.quantiles.empty() ? 0 : plan.samples());
    accumulators.emplace_back(quantity, size, kept * size);
  }
}

void Member::make_readings(const Simulation& start, const Plan& plan) {
  for (const Quantity& quantity : plan.what.quantities)
    readings_.push_back(make_reading(scene(), start, quantity.name));
}

const Scene& Member::scene() {
  if (all_->members().empty()) return *all_;
  if (!scene_) scene_ = std::make_unique<Scene>(all_->members()[index]);
  return *scene_;
}

PartialStep& Member::between() {
  if (!between_) between_ = std::make_unique<PartialStep>(scene());
  return *between_;
}

void Member::finish(const Simulation& now, const MemberEnd& how, const Plan& plan,
                    const std::stop_token& stop) {
  for (std::size_t q = 0; q < plan.reads.size(); ++q)
    reading(plan, q).read(now, plan.last(last, q), {}, stop);
  for (double& number : last) number = canonical(number);
  end = how;
}

void Member::save(ByteWriter& out) const {
  for (const Accumulators& one : accumulators) one.save(out);
  out.put(events);
  out.put(end.has_value());
  if (!end) return;
  out.put(static_cast<std::int32_t>(end->status.outcome));
  out.put(end->status.largest_step.has_value());
  out.put(end->status.largest_step.value_or(0));
  out.put(end->last_step);
  out.put(end->ended_by);
  out.put(end->rate);
  out.put(std::vector(last.begin(), last.end()));
}

void Member::restore(ByteReader& in) {
  end.reset();
  for (Accumulators& one : accumulators) one.restore(in);
  in.get(events);
  bool ended = false;
  in.get(ended);
  if (!ended) return;
  end.emplace();
  std::int32_t outcome = 0;
  bool has_step = false;
  double largest = 0;
  in.get(outcome);
  in.get(has_step);
  in.get(largest);
  in.get(end->last_step);
  in.get(end->ended_by);
  in.get(end->rate);
  in.require(outcome >= 0 && outcome <= static_cast<std::int32_t>(Outcome::cancelled));
  if (in.sound()) end->status.outcome = static_cast<Outcome>(outcome);
  if (has_step) end->status.largest_step = largest;
  std::vector<double> values(last.size());
  in.get(values);
  std::ranges::copy(values, last.begin());
}

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

}  // namespace stiefel
