#pragma once

#include <cmath>

#include "engine/linalg/follow_branch.h"
#include "engine/linalg/j_d_3.h"
#include "engine/linalg/j_d_n.h"
#include "engine/linalg/so_n.h"
#include "engine/maps/map.h"

namespace stiefel {

template <class Space, Arithmetic arithmetic>
struct JDInverseOf;
template <class Scalar, bool frame, Arithmetic arithmetic>
struct JDInverseOf<So3<Scalar, frame>, arithmetic> {
  using type = JDInverse3<Scalar, frame, arithmetic>;
};
template <class Scalar, Arithmetic arithmetic>
struct JDInverseOf<SoN<Scalar>, arithmetic> {
  using type = JDInverseN<Scalar, arithmetic>;
};

/// The Moser–Veselov step on (Q, M), [RB] (4.5) = (MDRBn), with physical momentum M and step h:
///
///     U = J_D⁻¹(hM),   J_D(U) = UΛ − ΛUᵀ,
///     Q_{k+1} = Q_k U,
///     M_{k+1} = Uᵀ M_k U,
///
/// U the solution on the branch that starts at the identity. For every N and every h for which it
/// is defined it keeps, exactly, QMQᵀ, the eigenvalues of M, every Manakov coefficient, and with
/// them the energy. Second order in Q, time-symmetric. Where there is no U: left_domain.
template <class Space, Arithmetic arithmetic>
class MoserVeselov {
 public:
  using Scalar = typename Space::Scalar;
  using Point = typename Space::State;
  using JDInverse = typename JDInverseOf<Space, arithmetic>::type;

  struct State {
    Accumulator<Point, arithmetic> x;
    typename JDInverse::Memory memory;

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
      memory.each(visit);
    }
  };

  MoserVeselov(const Vector<Scalar>& lambda, Scalar h)
      : h_(h), N_(lambda.size()), J_D_inverse_(lambda, h) {}

  State start(const Point& x) const {
    return {Accumulator<Point, arithmetic>(x), typename JDInverse::Memory(N_)};
  }

  Ending step(State& state) {
    if (!J_D_inverse_.solve(state.x, state.memory)) {
      if (!state.x.value.allFinite()) return {Outcome::not_finite, std::nullopt};
      const double reached = follow(state, 1);
      if (reached == 0) return {Outcome::solver_stalled, std::nullopt};
      if (reached < 1) return {Outcome::left_domain, reached * length()};
    }
    J_D_inverse_.transport(state.x, state.memory);
    return {};
  }

  /// The largest |h| up to `limit` for which a step from here exists, to 1e-3.
  std::optional<double> largest_step(const State& state, double limit) {
    return follow(state, limit / length()) * length();
  }

 private:
  double follow(const State& state, double end) {
    J_D_inverse_.restart();
    return follow_branch(end, [&](double t) { return J_D_inverse_.continue_to(state.x, t); });
  }

  double length() const { return std::abs(static_cast<double>(h_)); }

  Scalar h_;
  Eigen::Index N_;
  JDInverse J_D_inverse_;
};

}  // namespace stiefel
