#include "engine/accuracy/measured_motions.h"

#include <algorithm>
#include <utility>

namespace stiefel {
namespace {

MotionError larger(const MotionError& a, const MotionError& b) {
  MotionError out = a;
  if (b.attitude) out.attitude = std::max(a.attitude.value_or(0), *b.attitude);
  out.momentum = std::max(a.momentum, b.momentum);
  return out;
}

/// Merges the run of one more motion into that of the motions before it.
void take_in(const Run& one, Run& all) {
  all.errors.resize(std::min(all.errors.size(), one.errors.size()));
  for (std::size_t i = 0; i < all.errors.size(); ++i)
    all.errors[i] = larger(all.errors[i], one.errors[i]);
  all.steps = std::min(all.steps, one.steps);
  all.work += one.work;
  all.spent += one.spent;
  all.cpu_seconds += one.cpu_seconds;
  if (all.drift_of.empty() || one.drift > all.drift) {
    all.drift = one.drift;
    all.drift_of = one.drift_of;
  }
}

}  // namespace

MeasuredMotions::MeasuredMotions(std::vector<Scene> scenes)
    : scenes_(std::move(scenes)), of_each_(scenes_.size()) {}

bool MeasuredMotions::take(const MethodDescription& method) const {
  return std::ranges::all_of(scenes_, [&](const Scene& scene) {
    stop_point();
    return scene.with(method).has_value();
  });
}

void MeasuredMotions::solve_references(std::int64_t steps, Density density,
                                       const ReferenceNeed& need, const std::stop_token& stop) {
  common_ = {};
  double work = 0;
  for (std::size_t b = 0; b < count(); ++b) {
    const double share = (need.budget - work) / static_cast<double>(count() - b);
    Samples one = take_samples(scenes_[b], steps, density, {need.time, share, need.quadruple}, stop,
                               Choice::most_sample_bytes / static_cast<double>(count()));
    work += one.work;
    if (one.steps.empty()) {
      // The other references are not needed, because nothing can be measured on all motions.
      one.first_price *= static_cast<double>(count());
      one.work = work;
      of_each_.assign(count(), one);
      common_ = std::move(one);
      return;
    }
    take_in(one);
    of_each_[b] = std::move(one);
  }
}

void MeasuredMotions::take_in(const Samples& one) {
  if (common_.steps.empty()) {
    common_.steps = one.steps;
    for (const auto& answer : one.answers) common_.answers.push_back({{}, answer.error});
    common_.reference = one.reference;
    common_.work = one.work;
    common_.all_work = one.all_work;
    return;
  }
  // References that differ in the work of an answer have samples at different steps.
  Samples both;
  for (std::size_t i = 0, j = 0; i < common_.steps.size(); ++i) {
    while (j < one.steps.size() && one.steps[j] < common_.steps[i]) ++j;
    if (j == one.steps.size() || one.steps[j] != common_.steps[i]) continue;
    both.steps.push_back(common_.steps[i]);
    both.answers.push_back({{}, std::max(common_.answers[i].error, one.answers[j].error)});
  }
  common_.steps = std::move(both.steps);
  common_.answers = std::move(both.answers);
  if (common_.reference.find(one.reference) == std::string::npos)
    common_.reference += " or " + one.reference;
  common_.work += one.work;
  common_.all_work += one.all_work;
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
    Run one = stiefel::run(scenes_[b].with(method).value(), weight_of_one, of_each_[b], left);
    const RunStatus status = one.status;
    const double error = one.largest_error(one.errors.size());
    if (k == 0)
      all = std::move(one);
    else
      stiefel::take_in(one, all);
    if (error > largest) {
      largest = error;
      all.member = b;
    }
    if (status.reached() && !(error > bounds.most_error)) continue;
    all.status = status;
    if (count() > 1 && !status.reached()) all.status.member = static_cast<int>(b);
    break;
  }
  return all;
}

std::expected<MeasuredScene, Violations> what_is_measured(const SceneDescription& description) {
  if (description.members && *description.members > TradeoffRequest::most_members)
    return std::unexpected(Violations{Violation{
        "members", std::to_string(*description.members),
        "must be at most " + std::to_string(TradeoffRequest::most_members) +
            " where methods are measured, which keeps the reference of each; give a method"}});
  auto motions = motions_of(description);
  if (!motions) return std::unexpected(std::move(motions.error()));
  auto found = candidates(motions->front());
  if (!found) return std::unexpected(std::move(found.error()));
  MeasuredScene out{MeasuredMotions(*std::move(motions)), *std::move(found)};
  std::erase_if(out.candidates, [&](const Candidate& c) { return !out.motions.take(c.method); });
  for (Candidate& one : out.candidates) one.weight *= static_cast<double>(out.motions.count());
  return out;
}

}  // namespace stiefel
