#pragma once

#include <cmath>

#include "engine/dense/continuation.h"
#include "engine/methods/method.h"

namespace stiefel {

/// Finds U = J_D⁻¹(hM) on the branch that starts at the identity, and the outcome of a step that
/// has no such U, for all discrete rigid bodies. `JDInverse` is JDInverse3, JDInverse4, JDInverseN
/// or ModifiedJDInverse3; the states x hold M in the form that it expects.
template <class JDInverse>
class PrincipalBranch {
 public:
  using Memory = typename JDInverse::Memory;

  template <class Scalar, class... More>
  PrincipalBranch(const Vector<Scalar>& lambda, Scalar h, More... more)
      : h_(std::abs(static_cast<double>(h))), J_D_inverse_(lambda, h, more...) {}

  /// Returns the memory before the first step from a start.
  Memory memory(const auto&... start) const { return J_D_inverse_.memory(start...); }

  /// Finds U and stores it in the inverse. If there is none, the status gives the reason and the
  /// largest step that has a U.
  template <class X>
  RunStatus solve(const X& x, const Memory& memory) {
    if (J_D_inverse_.solve(x, memory)) return {};
    if (!x.value.allFinite()) return {Outcome::not_finite, std::nullopt};
    const double reached = follow(x, 1);
    if (reached == 0) return {Outcome::solver_stalled, std::nullopt};
    if (reached < 1) return {Outcome::left_domain, reached * h_};
    return {};
  }

  /// Returns the largest |h| up to `limit` for which there is a U, to 1e-3.
  template <class X>
  double largest_step(const X& x, double limit) {
    return follow(x, limit / h_) * h_;
  }

  JDInverse& inverse() { return J_D_inverse_; }
  const JDInverse& inverse() const { return J_D_inverse_; }

 private:
  template <class X>
  double follow(const X& x, double end) {
    J_D_inverse_.restart();
    const auto solve = [&](double t) { return J_D_inverse_.continue_to(x, t); };
    if constexpr (requires { J_D_inverse_.longest_stride(x.value); })
      return continuation(end, solve, J_D_inverse_.longest_stride(x.value));
    else
      return continuation(end, solve);
  }

  double h_;
  JDInverse J_D_inverse_;
};

}  // namespace stiefel
