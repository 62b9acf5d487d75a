#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/body/body_packs.h"
#include "engine/body/exact_body.h"

namespace stiefel {
namespace {

/// Bodies in three dimensions by the method `exact`. Those without a motion in theta functions are
/// left to their own Simulations.
class PackedClosedForms final : public PackedBodies {
 public:
  PackedClosedForms(std::span<const Scene> bodies, std::span<const double> start)
      : substeps_(bodies.front().substeps()) {
    times_.unit = bodies.front().step() / substeps_;
    const std::size_t each = start.size() / static_cast<std::size_t>(lanes());
    for (std::size_t lane = 0; lane * each < start.size(); ++lane)
      bodies_.push_back(top_in_time(bodies[std::min(lane, bodies.size() - 1)],
                                    start.subspan(lane * each, each - 1)));
  }

  int lanes() const override { return ThetaTop::lanes(); }

  Progress advance(std::span<double> states, std::int64_t steps) override {
    if (!std::exchange(ready_, true)) put_side_by_side();
    const std::size_t each = states.size() / bodies_.size();
    unsigned easy = 0;
    for (std::size_t lane = 0; lane < bodies_.size(); ++lane) {
      const double k = states[lane * each + each - 1] + static_cast<double>(steps) * substeps_;
      const auto& theta = bodies_[lane].theta();
      times_.high[lane] = k;
      times_.low[lane] = 0;
      const auto time = static_cast<double>(static_cast<long double>(k) * times_.unit);
      if (theta && std::abs(k) < largest && theta->takes(time)) easy |= 1u << lane;
    }
    if (easy == 0) return {0, 0};
    side_by_side_.at(times_, states_);
    for (std::size_t lane = 0; lane < bodies_.size(); ++lane) {
      if (!(easy >> lane & 1)) continue;
      TopInTime& body = bodies_[lane];
      const auto x = body.rounded(states_, static_cast<int>(lane));
      const auto to = states.subspan(lane * each, each);
      std::ranges::copy(x.tail(static_cast<Eigen::Index>(each) - 1), to.begin());
      to.back() = times_.high[lane];
    }
    if (easy == (1u << lanes()) - 1) return {steps, 0};
    return {0, easy};
  }

 private:
  static constexpr double largest = 0x1p53;  ///< numbers of steps below are exact

  /// Computes the constants of the motions, which takes longer than many states: at the first
  /// advance, for which an ensemble uses all cores.
  void put_side_by_side() {
    const auto some =
        std::ranges::find_if(bodies_, [](TopInTime& body) { return body.theta().has_value(); });
    for (int lane = 0; lane < lanes() && some != bodies_.end(); ++lane)
      side_by_side_.put(lane, bodies_[lane].theta() ? *bodies_[lane].theta() : *some->theta());
  }

  std::vector<TopInTime> bodies_;
  ThetaTops side_by_side_;
  ThetaTop::Times times_{};
  ThetaTop::Lanes states_;
  int substeps_;
  bool ready_ = false;
};

}  // namespace

std::unique_ptr<PackedBodies> pack_closed_forms(std::span<const Scene> bodies,
                                                std::span<const double> start) {
  return std::make_unique<PackedClosedForms>(bodies, start);
}

}  // namespace stiefel
