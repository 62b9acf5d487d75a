#include "stiefel/lyapunov.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/growth/confirmation.h"
#include "engine/growth/coordinates.h"
#include "engine/growth/lyapunov_run.h"
#include "engine/growth/tangent_of.h"
#include "stiefel/price.h"

namespace stiefel {

std::expected<LyapunovExponents, Violations> LyapunovExponents::make(
    const Scene& scene, const LyapunovDescription& what, const Simulation& start,
    const Place& place) {
  auto run = std::make_unique<LyapunovRun>(scene, what);
  if (auto violations = run->prepare(start, place); !violations.empty())
    return std::unexpected(std::move(violations));
  if (auto violations = run->begin(start, place); !violations.empty())
    return std::unexpected(std::move(violations));
  return LyapunovExponents(std::move(run));
}

std::int64_t LyapunovExponents::saved_step(std::string_view saved) {
  ByteReader in(saved);
  LyapunovHeader header;
  header.each([&](auto& number) { in.get(number); });
  return in.sound() && header.is == LyapunovHeader::format ? header.step : -1;
}

std::expected<LyapunovExponents, Violations> LyapunovExponents::resume(
    const Scene& scene, const LyapunovDescription& what, std::string_view saved,
    const Simulation& now, const Place& place) {
  const auto refused = [&] {
    return std::unexpected(Violations{place.violation(
        "checkpoint", std::to_string(saved.size()) + " bytes",
        "must come from a LyapunovExponents of the same request, whose `to` and `every` alone may "
        "differ, and not be beyond `to`")});
  };
  ByteReader in(saved);
  LyapunovHeader header;
  header.each([&](auto& number) { in.get(number); });
  const LyapunovHeader asked = LyapunovHeader::of(what);
  if (!in.sound() || header.is != LyapunovHeader::format || header.step != now.step() ||
      header.step < what.from || header.step > what.to || header.interval < 1 ||
      header.from != asked.from || header.count != asked.count ||
      header.asked_interval != asked.asked_interval || header.seed != asked.seed)
    return refused();
  auto run = std::make_unique<LyapunovRun>(scene, what);
  if (auto violations = run->prepare(now, place, header); !violations.empty())
    return std::unexpected(std::move(violations));
  if (!run->restore(in, now)) return refused();
  return LyapunovExponents(std::move(run));
}

std::string LyapunovExponents::save() const { return run_->save(); }

RunStatus LyapunovExponents::advance(Simulation& motion, std::int64_t steps,
                                     const std::stop_token& stop) {
  return run_->advance(motion, steps, stop);
}

bool LyapunovExponents::done() const { return run_->done(); }
bool LyapunovExponents::is_current() const { return run_->at() == run_->last_end(); }
std::int64_t LyapunovExponents::step() const { return run_->last_end(); }
std::int64_t LyapunovExponents::interval() const { return run_->interval(); }
std::int64_t LyapunovExponents::computed_steps() const { return run_->computed(); }
std::int64_t LyapunovExponents::covered_steps() const { return run_->covered(); }
Eigen::Index LyapunovExponents::vectors() const { return run_->growth().count(); }

Eigen::VectorXd LyapunovExponents::exponents() const {
  const Growth& growth = run_->growth();
  return growth.sums().head(run_->shown()) / growth.time();
}
Eigen::VectorXd LyapunovExponents::errors() const {
  const Growth& growth = run_->growth();
  const double powers = std::log1p(run_->rate() * growth.time()) / growth.time();
  return growth.batch_means().errors.head(run_->shown()).array() + powers;
}
Eigen::VectorXd LyapunovExponents::log_gali() const {
  return run_->growth().log_gali().head(std::max<Eigen::Index>(run_->shown() - 1, 0));
}
MotionKind LyapunovExponents::kind() const { return run_->judgement().kind; }
std::string LyapunovExponents::reason() const { return run_->judgement().reason; }

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

LyapunovExponents::LyapunovExponents(std::unique_ptr<LyapunovRun> run) : run_(std::move(run)) {}
LyapunovExponents::LyapunovExponents(LyapunovExponents&&) noexcept = default;
LyapunovExponents& LyapunovExponents::operator=(LyapunovExponents&&) noexcept = default;
LyapunovExponents::~LyapunovExponents() = default;

}  // namespace stiefel
