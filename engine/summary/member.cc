#include "engine/summary/member.h"

#include <algorithm>

namespace stiefel {

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
  if (end) save_end(out);
}

void Member::save_end(ByteWriter& out) const {
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
  if (ended) restore_end(in);
}

void Member::restore_end(ByteReader& in) {
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

}  // namespace stiefel
