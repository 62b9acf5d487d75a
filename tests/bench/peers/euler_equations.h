#pragma once

#include <array>
#include <cstdint>

namespace stiefel::bench {

/// The equations of a free body for general ODE solvers: Euler's equations in body axes and the
/// quaternion of Q, q̇ = ½ q∘(0, ω), I₁ω̇₁ = (I₂ − I₃)ω₂ω₃ and cyclic. Counts its evaluations.
class EulerEquations {
 public:
  /// q = (w, x, y, z), followed by ω.
  using State = std::array<double, 7>;

  explicit EulerEquations(const std::array<double, 3>& I)
      : k_{(I[1] - I[2]) / I[0], (I[2] - I[0]) / I[1], (I[0] - I[1]) / I[2]} {}

  void operator()(const State& state, State& rate, double) {
    const auto& [w, x, y, z, o1, o2, o3] = state;
    const double a = o1 / 2, b = o2 / 2, c = o3 / 2;
    rate = {-(x * a + y * b + z * c), w * a + y * c - z * b, w * b + z * a - x * c,
            w * c + x * b - y * a,    k_[0] * o2 * o3,       k_[1] * o3 * o1,
            k_[2] * o1 * o2};
    ++evaluations_;
  }

  std::int64_t evaluations() const { return evaluations_; }

 private:
  std::array<double, 3> k_;
  std::int64_t evaluations_ = 0;
};

}  // namespace stiefel::bench
