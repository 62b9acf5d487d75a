#include "engine/tangent/lyapunov_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/numbers/to_text.h"
#include "engine/tangent/systems.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

/// Returns the steps of about one radian of the motion.
std::int64_t chosen_interval(const Scene& scene, double rate) {
  const double steps = std::ceil(1 / (rate * std::abs(scene.step())));
  constexpr double most = 1 << 20;
  return std::isfinite(steps) ? static_cast<std::int64_t>(std::clamp(steps, 1.0, most)) : 1;
}

}  // namespace

LyapunovHeader LyapunovHeader::of(const LyapunovDescription& what) {
  return {
      .from = what.from, .count = what.count, .asked_interval = what.interval, .seed = what.seed};
}

Violations LyapunovRun::prepare(const Simulation& start, const Place& place,
                                const std::optional<LyapunovHeader>& saved) {
  if (!scene_.members().empty())
    return {place.violation("", std::to_string(scene_.members().size()) + " members",
                            "the scene must have no `members`")};
  const auto tangents = tangents_of(scene_.system());
  if (!tangents) return {place.violation("", scene_.system(), "has no tangent map")};
  vectors_.emplace(scene_, tangents->space(scene_), start);
  const std::int64_t dimension = vectors_->dimension(vectors_->state(start));
  if (dimension == 0 && what_.count == 0)
    return {place.violation("count", "0",
                            "must be given: all exponents are offered for states of up to " +
                                std::to_string(Linearization::largest_in_coordinates) +
                                " numbers")};
  const std::int64_t most = dimension > 0 ? dimension : GrowthVectors::most_of_large;
  if (what_.count < 0 || what_.count > most)
    return {place.violation("count", std::to_string(what_.count),
                            "must be 0, for all, or at most " + std::to_string(most))};
  // Four vectors cost no more than one.
  count_ = static_cast<Eigen::Index>(std::min<std::int64_t>(
      most, what_.count == 0 ? most : std::max<std::int64_t>(what_.count, TangentMap::lanes)));
  growth_ = Growth(count_);
  rate_ = saved ? saved->rate : start.rate();
  at_ = last_end_ = start.step();
  interval_ = saved                ? saved->interval
              : what_.interval > 0 ? what_.interval
                                   : chosen_interval(scene_, rate_);
  if (what_.interval < 0)
    return {place.violation("interval", std::to_string(what_.interval), "must be at least 0")};
  if ((what_.to - what_.from) / interval_ < LyapunovExponents::least_intervals)
    return {place.violation(
        "to", std::to_string(what_.to),
        "must be at least " +
            std::to_string(what_.from + LyapunovExponents::least_intervals * interval_) + ": " +
            std::to_string(LyapunovExponents::least_intervals) + " intervals of " +
            std::to_string(interval_) + " steps after `from`")};
  return {};
}

Violations LyapunovRun::restart(const Simulation& motion, const Place& place) {
  linearization_.reset();
  LinearizationDescription moved;
  moved.vectors = vectors_->by_rows(V_);
  moved.as_blocks = true;
  auto made = Linearization::make(scene_, std::move(moved), motion, place);
  if (!made) return std::move(made.error());
  linearization_.emplace(*std::move(made));
  return {};
}

RunStatus LyapunovRun::close(const Simulation& motion) {
  V_ = vectors_->by_columns(linearization_->vectors(motion));
  if (!V_.allFinite()) return {Outcome::not_finite, std::nullopt};
  const Dense R = vectors_->orthonormalise(vectors_->state(motion), V_);
  if (!(R.diagonal().minCoeff() > 0) || !R.allFinite()) return {Outcome::not_finite, std::nullopt};
  growth_.add(static_cast<double>(at_ - last_end_) * std::abs(scene_.step()), R);
  last_end_ = at_;
  if (at_ < what_.to && what_.to - at_ < interval_) saved_ = write();
  if (at_ < what_.to && !restart(motion).empty()) return {Outcome::not_finite, std::nullopt};
  return {};
}

RunStatus LyapunovRun::advance(Simulation& motion, std::int64_t steps,
                               const std::stop_token& stop) {
  if (at_ == what_.to && beside_) return advance_beside(steps, stop);
  do {
    const std::int64_t left = interval_end() - at_;
    const std::int64_t now = motion.direct() ? left : std::min(steps, left);
    RunStatus status = linearization_->advance(motion, now, stop);
    computed_ += motion.direct() ? 1 : motion.step() - at_;
    at_ = motion.step();
    if (status.reached() && at_ == interval_end()) status = close(motion);
    if (!status.reached()) {
      ended_ = true;
      judgement_.reason =
          "The motion ended at step " + std::to_string(at_) + ", before the last one.";
      return status;
    }
    if (!judged_ && growth_.sums()(0) >= beside_enough) what_.to = at_;
    steps -= motion.direct() ? steps : now;
  } while (steps > 0 && at_ < what_.to);
  if (at_ == what_.to) judge(motion);
  return {};
}

void LyapunovRun::judge(const Simulation& motion) {
  if (!judged_) return;
  judgement_ = judge_growth(growth_, rate_);
  if (judgement_.kind != MotionKind::chaotic) return;
  // What looks chaotic is so if a motion beside it, with shorter steps, is too. It starts where the
  // steps have not yet drifted from the flow, if that state is at hand.
  const double lambda = growth_.sums()(0) / growth_.time();
  LyapunovDescription what;
  what.interval = interval_;
  what.count = std::min<std::int64_t>(2, count_);
  const double steps = beside_growth / (lambda * std::abs(scene_.step()));
  what.to = (static_cast<std::int64_t>(steps) / interval_ + 1) * interval_;
  what.to = std::max(what.to, LyapunovExponents::least_intervals * interval_);
  if (const auto scene = what_.from == 0 ? beside(*make_simulation(scene_)) : beside(motion)) {
    beside_ = std::make_unique<LyapunovRun>(*scene, what, false);
    other_ = make_simulation(*scene);
    if (!beside_->prepare(*other_).empty() || !beside_->begin(*other_).empty()) beside_.reset();
  }
  if (!beside_) judgement_ = confirm(judgement_, growth_, nullptr, false);
}

std::optional<Scene> LyapunovRun::beside(const Simulation& start) const {
  const Dense x = vectors_->state(start), V = vectors_->random(x, 1, what_.seed + 1);
  return scene_beside(scene_, start, V.reshaped(x.rows(), V.rows() / x.rows()));
}

RunStatus LyapunovRun::advance_beside(std::int64_t steps, const std::stop_token& stop) {
  const RunStatus status = beside_->advance(*other_, steps, stop);
  if (status.outcome == Outcome::cancelled) {
    ended_ = true;
    return status;
  }
  if (!beside_->done()) return {};
  judgement_ = confirm(judgement_, growth_, &beside_->growth_, status.reached());
  computed_beside_ = beside_->computed_;
  beside_.reset();
  other_.reset();
  return {};
}

std::string LyapunovRun::write() const {
  ByteWriter out;
  LyapunovHeader header = LyapunovHeader::of(what_);
  header.step = last_end_;
  header.interval = interval_;
  header.rate = rate_;
  header.each([&](const auto& number) { out.put(number); });
  for (const double w : vectors_->weights()) out.put(w);
  for (const double v : V_.reshaped()) out.put(v);
  growth_.save(out);
  return out.take();
}

bool LyapunovRun::restore(ByteReader& in, const Simulation& now) {
  Eigen::VectorXd weights = vectors_->weights();
  for (double& w : weights) in.get(w);
  V_.resize(vectors_->size(), count_);
  for (double& v : V_.reshaped()) in.get(v);
  growth_.restore(in);
  if (!in.complete() || !V_.allFinite()) return false;
  vectors_->set_weights(weights);
  if (at_ == what_.to) {
    judge(now);
    return true;
  }
  if (what_.to - at_ < interval_) saved_ = write();
  return restart(now).empty();
}

}  // namespace stiefel
