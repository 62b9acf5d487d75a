#pragma once

#include <array>
#include <optional>

#include "engine/dense/principal_moments_3.h"
#include "engine/numbers/isa.h"
#include "engine/numbers/number_128.h"

namespace stiefel {

/// A free rigid body in three dimensions by Jacobi's theta functions, in two-word arithmetic: the
/// states at many times, or of many bodies, in the lanes of vector registers. In the axes (a, b,
/// c), where m circles a and b is the axis of the middle moment, and with z = πu/2K and β = π(K′ −
/// y)/2K,
///
///     m = (B_a dn u, B_b sn u, B_c cn u),   y = B_a R_F(B_c², B_b², |m|²),
///     q = A ∘ e^{iα}(Z₁, Z₂)/|Z|,   Z₁ = θ₄(z + iβ), Z₂ = −i θ₁(z + iβ), the nome exp(−2πK′/K),
///
/// where Z₁ = q_w + i q_a, Z₂ = q_b + i q_c, and u and α are linear in time. The constants of the
/// motion are computed once, their rates with 120 bits. A state then takes two phases
/// modulo 1, their sines and cosines, and polynomials of degree 4 in sin²z. Next to the separatrix,
/// where the nome is near 1, the series are those of Jacobi's imaginary transformation, in powers
/// of e^{−πu/2K′}.
///
/// The error of a state is about 2^-57 of it, and 2^-102 more for each turn. All instruction sets
/// give the same bits.
///
/// Jacobi, Sur la rotation d'un corps, 1849; Whittaker and Watson, chapter XXI.
class ThetaTop {
 public:
  static constexpr int numbers = 7;  ///< of a state: (q; m), q = (w, x, y, z)
  static constexpr int constants = 71;
  static constexpr int most_lanes = 8;

  /// The times `unit` · (high + low), lane by lane, in unevaluated sums.
  struct Times {
    double unit;
    alignas(64) std::array<double, most_lanes> high, low;
  };
  /// What the lanes hold: numbers of states in two words, in the axes (a, b, c).
  struct Lanes {
    alignas(64) std::array<double, 2 * numbers * most_lanes> words;
    int width;
  };
  /// A state as unevaluated sums, along the axes of the body. `high` is the state rounded.
  struct State {
    std::array<double, numbers> high, low;
  };

  /// Returns the motion from (q; m) at time 0. There is none for steady motions, on the separatrix,
  /// and where a constant is so large or so small that products of two words could overflow or lose
  /// bits; EulerTop moves these.
  static std::optional<ThetaTop> of(const PrincipalMoments3<Number128>& body,
                                    const Eigen::Matrix<long double, 7, 1>& start);

  /// Whether a time is such that its phases keep their bits.
  bool takes(double time) const {
    const double size = time < 0 ? -time : time;
    return size < longest_ && (size > shortest || size == 0);
  }

  /// Returns how many states are computed together on this machine.
  static int lanes();

  /// The constants of the motion, in the order of theta_constants.h.
  const double* numbers_of_motion() const { return constants_.data(); }

  /// Computes the states at several times.
  void at(const Times& times, Lanes& states) const;
  /// Returns the state in a lane.
  State state(const Lanes& states, int lane) const {
    return {words(states, lane), words(states, lane + numbers * states.width)};
  }
  /// Returns the state in a lane, rounded.
  std::array<double, numbers> rounded(const Lanes& states, int lane) const {
    return words(states, lane);
  }

 private:
  friend class ThetaTops;
  ThetaTop() = default;

  std::array<double, numbers> words(const Lanes& states, int first) const {
    const double* from = &states.words[first];
    std::array<double, numbers> to;
    to[0] = from[0];
    for (int n = 0; n < 3; ++n) {
      to[1 + axis_[n]] = sign_[n] * from[(1 + n) * states.width];
      to[4 + axis_[n]] = sign_[n] * from[(4 + n) * states.width];
    }
    return to;
  }

  static constexpr double shortest = 0x1p-300;

  std::array<double, constants> constants_;
  double longest_;           ///< all times are shorter
  std::array<int, 3> axis_;  ///< a, b and c as axes of the body
  std::array<double, 3> sign_;
};

/// Bodies side by side, one in each lane.
class ThetaTops {
 public:
  /// Puts a body into a lane. Every lane needs one.
  void put(int lane, const ThetaTop& body);
  /// Computes the state of each body at its time.
  void at(const ThetaTop::Times& times, ThetaTop::Lanes& states) const;

 private:
  alignas(64) std::array<double, ThetaTop::constants * ThetaTop::most_lanes> constants_;
};

/// The kernels of ThetaTop and ThetaTops, for the constants of one body or those of each lane, one
/// constant after another; compiled for each instruction set from theta_lanes.cc.in.
template <Isa isa>
void theta_states_of_one(const double* constants, const ThetaTop::Times& times, double* states);
template <Isa isa>
void theta_states_side_by_side(const double* constants, const ThetaTop::Times& times,
                               double* states);

}  // namespace stiefel
