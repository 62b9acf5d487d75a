#pragma once

#include "engine/body/j_d/j_d_3.h"
#include "engine/body/j_d/j_d_4.h"
#include "engine/body/j_d/j_d_n.h"
#include "engine/body/principal_branch.h"
#include "engine/dense/so_n.h"

namespace stiefel {

template <class Space>
struct JDInverseOf;
template <class Scalar, bool frame>
struct JDInverseOf<So3<Scalar, frame>> {
  using type = JDInverse3<Scalar, frame>;
};
template <class Scalar, bool frame>
struct JDInverseOf<So4<Scalar, frame>> {
  using type = JDInverse4<Scalar, frame>;
};
template <>
struct JDInverseOf<SoN<double>> {
  using type = JDInverseN;
};

/// The Moser–Veselov step on (Q, M), [RB] (4.5) = (MDRBn), with physical momentum M and step h:
///
///     U = J_D⁻¹(hM),   J_D(U) = UΛ − ΛUᵀ,
///     Q_{k+1} = Q_k U,
///     M_{k+1} = Uᵀ M_k U,
///
/// U is the solution on the branch that starts at the identity. For every N, and every h for which
/// U exists, the step keeps QMQᵀ, the eigenvalues of M, every Manakov coefficient, and hence the
/// energy exactly. Order 2 in Q, time-symmetric. Ends with left_domain where there is no U. The
/// memory of another `JDInverse` may depend on the start.
template <class Space, class JDInverse = typename JDInverseOf<Space>::type>
class MoserVeselov {
 public:
  using Scalar = typename Space::Scalar;
  using Point = typename Space::State;
  static constexpr bool only_rotates = true;
  static constexpr bool stops_before_change() { return true; }

  struct State {
    Accumulator<Point> x;
    typename JDInverse::Memory memory;

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
      memory.each(visit);
    }
  };

  /// `more` are further arguments of JDInverse: in three and four dimensions whether the scene has
  /// a Q.
  template <class... More>
  MoserVeselov(const Vector<Scalar>& lambda, Scalar h,
               Arithmetic arithmetic = Arithmetic::compensated, More... more)
      : arithmetic_(arithmetic), branch_(lambda, h, more...) {}

  State start(const Point& x) const {
    return {Accumulator<Point>(x, arithmetic_), branch_.memory(x)};
  }

  RunStatus step(State& state) {
    const RunStatus status = branch_.solve(state.x, state.memory);
    if (status.reached()) branch_.inverse().transport(state.x, state.memory);
    return status;
  }

  /// Returns the largest |h| up to `limit` for which a step from `state` exists, to 1e-3.
  std::optional<double> largest_step(const State& state, double limit) {
    return branch_.largest_step(state.x, limit);
  }

 private:
  Arithmetic arithmetic_;
  PrincipalBranch<JDInverse> branch_;
};

}  // namespace stiefel
