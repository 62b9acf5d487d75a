#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "engine/body/exact/euler_top.h"
#include "engine/body/exact/theta_top.h"

namespace stiefel {

/// The free rigid body in three dimensions at any time: ThetaTop where it takes the motion and the
/// time, else EulerTop in extended precision. It computes as many states together as a register has
/// lanes: after steps k and k + d also those at k + 2d, k + 3d, …, and of given times the next
/// ones. The constants of the motion are computed at first use.
///
/// A state is (q; m) in the axes of the scene, which the unit quaternion `axes` turns to the
/// principal ones: u along these is axes u axes* in the scene.
class TopInTime {
 public:
  using Wide = long double;
  using Point = So3<double, true>::State;
  using WidePoint = So3<Wide, true>::State;
  using Quaternion = Eigen::Matrix<Wide, 4, 1>;

  /// `lost` is added to the momentum of the start: what it has lost by rounding.
  TopInTime(const PrincipalMoments3<Number128>& body, const WidePoint& start,
            const Quaternion& axes = Quaternion::UnitX(),
            const Vector3<Wide>& lost = Vector3<Wide>::Zero())
      : body_(body), axes_(axes), turned_(axes.tail<3>() != Vector3<Wide>::Zero()), lost_(lost) {
    start_ = start;
    start_.tail<3>() += lost;
    if (turned_) start_ = in_axes_turned_by(axes_, start_);
    asked_.fill(std::numeric_limits<Wide>::quiet_NaN());
  }

  /// Returns the motion of the same body from another state.
  TopInTime from(const WidePoint& start) const { return {body_, start, axes_, lost_}; }

  /// Returns the state after k steps of length h, rounded.
  Point at(Wide k, double h) {
    const Wide distance = k - std::exchange(last_, k);
    return at(k, h, [&](int lane) { return k + lane * distance; });
  }
  /// Returns the state at the first of several times, rounded.
  Point at(std::span<const double> times) {
    return at(times[0], 1, [&](int lane) -> Wide {
      return times[std::min(static_cast<std::size_t>(lane), times.size() - 1)];
    });
  }

  /// The motion, if there is one in theta functions.
  const std::optional<ThetaTop>& theta() {
    if (!made_) {
      theta_ = ThetaTop::of(body_, start_);
      made_ = true;
    }
    return theta_;
  }
  /// Returns what theta() found, once it was called.
  const std::optional<ThetaTop>& theta_found() const { return theta_; }
  /// Returns the state of theta() in a lane, rounded, in the axes of the scene.
  Point rounded(const ThetaTop::Lanes& lanes, int lane) const {
    if (!turned_) return Point(theta_->rounded(lanes, lane).data());
    const ThetaTop::State state = theta_->state(lanes, lane);
    WidePoint x;
    for (int i = 0; i < ThetaTop::numbers; ++i) x(i) = Wide(state.high[i]) + Wide(state.low[i]);
    return in_scene(x);
  }

 private:
  Point in_scene(const WidePoint& x) const {
    return (turned_ ? in_axes_turned_by(conjugate(axes_), x) : x).cast<double>();
  }

  template <class Following>
  Point at(Wide k, double h, Following&& following) {
    if (asked_[lane_] != k || times_.unit != h) {
      if (!theta() || !theta_->takes(static_cast<double>(k * h))) return alone(k * h);
      find(k, h, following);
    }
    return rounded(lanes_, lane_++);
  }

  /// Finds the lane of a state, or computes the state with those that follow it.
  template <class Following>
  void find(Wide k, double h, Following&& following) {
    const int width = ThetaTop::lanes();
    if (times_.unit == h)
      for (lane_ = 0; lane_ < width; ++lane_)
        if (asked_[lane_] == k) return;
    times_.unit = h;
    for (int lane = 0; lane < width; ++lane) {
      const Wide asked = lane == 0 ? k : following(lane);
      const bool takes = theta_->takes(static_cast<double>(asked * h));
      asked_[lane] = takes ? asked : std::numeric_limits<Wide>::quiet_NaN();
      times_.high[lane] = static_cast<double>(takes ? asked : k);
      times_.low[lane] = static_cast<double>((takes ? asked : k) - times_.high[lane]);
    }
    theta_->at(times_, lanes_);
    lane_ = 0;
  }

  Point alone(Wide t) {
    if (!euler_)
      euler_.emplace(
          PrincipalMoments3<Wide>(body_.moments.cast<Wide>(), body_.differences.cast<Wide>()),
          start_);
    return in_scene(euler_->at(t));
  }

  static Quaternion conjugate(const Quaternion& q) { return {q(0), -q(1), -q(2), -q(3)}; }
  /// Returns (q; m) in the axes of x turned by r, which are the vectors r e_i r*: (q∘r; r* m r).
  static WidePoint in_axes_turned_by(const Quaternion& r, const WidePoint& x) {
    WidePoint y;
    y << So3<Wide, true>::quaternion_times(x, r(0), r.tail<3>()),
        rotation_matrix<Wide>(r).transpose() * x.tail<3>();
    return y;
  }

  PrincipalMoments3<Number128> body_;
  Quaternion axes_;
  bool turned_;
  Vector3<Wide> lost_;
  WidePoint start_;  ///< along the principal axes
  std::optional<ThetaTop> theta_;
  std::optional<EulerTop<Wide>> euler_;
  bool made_ = false;

  /// The times in the lanes, NaN where there is none, and one more that is never asked for.
  std::array<Wide, ThetaTop::most_lanes + 1> asked_;
  ThetaTop::Times times_{.unit = 0, .high = {}, .low = {}};
  ThetaTop::Lanes lanes_;
  int lane_ = 0;  ///< where the next state is expected
  Wide last_ = 0;
};

}  // namespace stiefel
