#include "engine/growth/lyapunov_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/growth/confirmation.h"
#include "stiefel/price.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

/// Returns the steps of about one radian of the motion.
std::int64_t chosen_interval(const Scene& scene, double rate) {
  const double steps = std::ceil(1 / (rate * std::abs(scene.step())));
  constexpr double most = 1 << 20;
  return std::isfinite(steps) ? static_cast<std::int64_t>(std::clamp(steps, 1.0, most)) : 1;
}

}  // namespace

LyapunovRun::LyapunovRun(const Scene& scene, const LyapunovDescription& what, bool judged)
    : scene_(scene), what_(what), judged_(judged), growth_(1) {}
LyapunovRun::~LyapunovRun() = default;

Violations LyapunovRun::prepare(const Simulation& start,
                                const std::optional<LyapunovHeader>& saved) {
  if (Violations none = without_tangent(scene_); !none.empty()) return none;
  vectors_.emplace(scene_, start);
  const std::int64_t dimension = vectors_->dimension(blocks_of(start));
  if (dimension == 0 && what_.count == 0)
    return {Violation{"count", "0",
                      "must be given: all exponents are offered for states of up to " +
                          std::to_string(Linearization::largest_in_coordinates) + " numbers"}};
  const std::int64_t most = dimension > 0 ? dimension : GrowthVectors::most_of_large;
  if (what_.count < 0 || what_.count > most)
    return {Violation{"count", std::to_string(what_.count),
                      "must be 0, for all, or at most " + std::to_string(most)}};
  count_ = static_cast<Eigen::Index>(
      std::min<std::int64_t>(most, what_.count == 0 ? most : std::max(what_.count, least_vectors)));
  growth_ = Growth(count_);
  rate_ = saved ? saved->rate : start.rate();
  fastest_ = saved ? saved->fastest : rate_;
  first_.resize(start.saved_size());
  at_ = last_end_ = start.step();
  interval_ = saved                ? saved->interval
              : what_.interval > 0 ? what_.interval
                                   : chosen_interval(scene_, rate_);
  if (what_.interval < 0)
    return {Violation{"interval", std::to_string(what_.interval), "must be at least 0"}};
  if ((what_.to - what_.from) / interval_ < LyapunovExponents::least_intervals)
    return {
        Violation{"to", std::to_string(what_.to),
                  "must be at least " +
                      std::to_string(what_.from + LyapunovExponents::least_intervals * interval_) +
                      ": " + std::to_string(LyapunovExponents::least_intervals) + " intervals of " +
                      std::to_string(interval_) + " steps after `from`"}};
  return {};
}

Violations LyapunovRun::begin(const Simulation& start) {
  V_ = vectors_->random(blocks_of(start), count_, what_.seed);
  start.save(first_);
  return restart(start);
}

Violations LyapunovRun::restart(const Simulation& motion) {
  linearization_.reset();
  auto made = Linearization::make(scene_, {vectors_->by_rows(V_), true}, motion);
  if (!made) return std::move(made.error());
  linearization_ = *std::move(made);
  return {};
}

RunStatus LyapunovRun::close(const Simulation& motion) {
  V_ = vectors_->by_columns(linearization_->vectors(motion));
  if (!V_.allFinite()) return {Outcome::not_finite, std::nullopt};
  const Dense R = vectors_->orthonormalise(blocks_of(motion), V_);
  if (!(R.diagonal().minCoeff() > 0) || !R.allFinite()) return {Outcome::not_finite, std::nullopt};
  growth_.add(static_cast<double>(at_ - last_end_) * std::abs(scene_.step()), R);
  last_end_ = at_;
  fastest_ = std::max(fastest_, motion.rate());
  if (at_ < what_.to && what_.to - at_ < interval_) saved_ = write();
  if (at_ < what_.to && !restart(motion).empty()) return {Outcome::not_finite, std::nullopt};
  return {};
}

RunStatus LyapunovRun::advance(Simulation& motion, std::int64_t steps,
                               const std::stop_token& stop) {
  if (confirmation_) return confirm(static_cast<double>(steps), motion.step_cost(), stop);
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
    steps -= motion.direct() ? steps : now;
  } while (steps > 0 && at_ < what_.to);
  if (at_ == what_.to) judge();
  return {};
}

void LyapunovRun::judge() {
  if (!judged_) return;
  judgement_ = judge_growth(growth_, rate_);
  std::string none;
  if (judgement_.kind == MotionKind::chaotic) none = begin_confirmation();
  if (!confirmation_) {
    saved_confirmation_.clear();
    attempt_ = confirmed_to_ = 0;
  }
  if (!none.empty()) judgement_ = {MotionKind::undecided, judgement_.reason + ". " + none};
}

std::string LyapunovRun::begin_confirmation() {
  // A longer run begins with the first attempt.
  if (attempt_ > 0 && confirmed_to_ != what_.to) {
    saved_confirmation_.clear();
    attempt_ = 0;
  }
  confirmed_to_ = what_.to;
  const auto start = make_simulation(scene_);
  start->restore(what_.from, first_);
  const Dense x = blocks_of(*start), V = vectors_->random(x, 1, what_.seed + 1 + attempt_);
  const Confirmation::First first{
      .scene = scene_,
      .start = *start,
      .direction = V.reshaped(x.rows(), V.rows() / x.rows()),
      .interval = interval_,
      .intervals = intervals(),
      .fastest = fastest_,
      .what = {.count = std::min<std::int64_t>(2, count_), .seed = what_.seed}};
  confirmation_ = std::make_unique<Confirmation>();
  std::string none = confirmation_->begin(first);
  if (none.empty() && !saved_confirmation_.empty() && !confirmation_->restore(saved_confirmation_))
    none = confirmation_->begin(first);
  if (!none.empty()) confirmation_.reset();
  return none;
}

RunStatus LyapunovRun::confirm(double steps, double step_cost, const std::stop_token& stop) {
  const RunStatus status = confirmation_->advance(steps, step_cost, stop);
  if (status.outcome == Outcome::cancelled) {
    ended_ = true;
    return status;
  }
  if (!confirmation_->done()) return {};
  const Judgement found = confirmed(judgement_, growth_, confirmation_->run().growth(), rate_,
                                    status.reached(), confirmation_->how(), attempt_);
  computed_beside_ += confirmation_->run().computed_steps();
  if (found.kind != MotionKind::chaotic && attempt_ + 1 < Confirmation::most_attempts) {
    saved_confirmation_.clear();
    ++attempt_;
    if (begin_confirmation().empty()) return {};
  }
  judgement_ = found;
  if (confirmation_) saved_confirmation_ = confirmation_->save();
  confirmation_.reset();
  return {};
}

Eigen::VectorXd LyapunovRun::errors() const {
  const double powers = std::log1p(rate_ * growth_.time()) / growth_.time();
  return growth_.batch_means().errors.head(shown()).array() + powers;
}

std::int64_t LyapunovRun::computed_steps() const {
  return computed_ + computed_beside_ + (confirmation_ ? confirmation_->run().computed_steps() : 0);
}

std::int64_t LyapunovRun::covered_steps() const {
  const std::int64_t own = last_end_ - what_.from;
  if (!confirmation_) return own;
  const LyapunovRun& other = confirmation_->run();
  return own + (attempt_ * intervals() + other.step() / other.interval()) * interval_;
}

std::string LyapunovRun::save() const {
  ByteWriter out;
  out.put(attempt_);
  out.put(confirmed_to_);
  out.put(confirmation_ ? confirmation_->save() : saved_confirmation_);
  return (saved_.empty() ? write() : saved_) + out.take();
}

std::string LyapunovRun::write() const {
  ByteWriter out;
  LyapunovHeader header = LyapunovHeader::of(what_);
  header.step = last_end_;
  header.interval = interval_;
  header.rate = rate_;
  header.fastest = fastest_;
  header.each([&](const auto& number) { out.put(number); });
  out.put(first_);
  for (const double w : vectors_->weights()) out.put(w);
  for (const double v : V_.reshaped()) out.put(v);
  growth_.save(out);
  return out.take();
}

bool LyapunovRun::restore(ByteReader& in, const Simulation& now) {
  in.get(first_);
  Eigen::VectorXd weights = vectors_->weights();
  for (double& w : weights) in.get(w);
  V_.resize(vectors_->size(), count_);
  for (double& v : V_.reshaped()) in.get(v);
  growth_.restore(in);
  in.get(attempt_);
  in.get(confirmed_to_);
  in.get_up_to(std::numeric_limits<std::int32_t>::max(), saved_confirmation_);
  in.require(attempt_ >= 0 && attempt_ < Confirmation::most_attempts);
  if (!in.complete() || !V_.allFinite()) return false;
  vectors_->set_weights(weights);
  if (at_ == what_.to) {
    judge();
    return true;
  }
  if (what_.to - at_ < interval_) saved_ = write();
  return restart(now).empty();
}

LyapunovExponents::Made LyapunovExponents::make(const Scene& scene, const LyapunovDescription& what,
                                                const Simulation& start) {
  auto run = std::make_unique<LyapunovRun>(scene, what);
  Violations violations = run->prepare(start);
  if (violations.empty()) violations = run->begin(start);
  if (!violations.empty()) return std::unexpected(std::move(violations));
  return run;
}

std::int64_t LyapunovExponents::saved_step(std::string_view saved) {
  ByteReader in(saved);
  const LyapunovHeader header = LyapunovHeader::read(in);
  return in.sound() && header.is == LyapunovHeader::format ? header.step : -1;
}

LyapunovExponents::Made LyapunovExponents::resume(const Scene& scene,
                                                  const LyapunovDescription& what,
                                                  std::string_view saved, const Simulation& now) {
  ByteReader in(saved);
  const LyapunovHeader header = LyapunovHeader::read(in), asked = LyapunovHeader::of(what);
  const bool fits = in.sound() && header.is == LyapunovHeader::format &&
                    header.step == now.step() && header.step >= what.from &&
                    header.step <= what.to && header.interval >= 1 && header.asked == asked.asked;
  auto run = std::make_unique<LyapunovRun>(scene, what);
  if (Violations violations = fits ? run->prepare(now, header) : Violations(); !violations.empty())
    return std::unexpected(std::move(violations));
  if (fits && run->restore(in, now)) return run;
  return std::unexpected(Violations{Violation{
      "checkpoint", std::to_string(saved.size()) + " bytes",
      "must come from a LyapunovExponents of the same request, whose `to` and `every` alone may "
      "differ, and not be beyond `to`"}});
}

std::uint64_t lyapunov_bytes(const Scene& scene, const LyapunovDescription& what,
                             std::int64_t size) {
  if (!tangents_of(scene.system())) return 0;
  const StateExtent x = extent_of(scene);
  const std::int64_t vectors =
      std::min({what.count > 0 ? std::max(what.count, LyapunovRun::least_vectors) : size, size,
                static_cast<std::int64_t>(x.dimension)});
  const auto m = static_cast<std::uint64_t>(vectors), D = static_cast<std::uint64_t>(size);
  const std::uint64_t squares = x.is_body || size > Linearization::largest_in_coordinates ? 0 : 3;
  // The state of the second motion is saved twice.
  const Scene map = confirming_scene(scene);
  const auto beside = std::min<std::uint64_t>(m, LyapunovRun::least_vectors);
  return linearization_bytes(scene, vectors, false) +
         linearization_bytes(map, static_cast<std::int64_t>(beside), false) +
         2 * simulation_bytes(scene) + 3 * simulation_bytes(map) +
         sizeof(double) *
             (6 * D * (m + beside) + squares * D * D + 256 * (m + beside + 16) + 8 * m * m);
}

}  // namespace stiefel
