#pragma once

#include <memory>

#include "engine/dense/history.h"
#include "engine/numbers/compensated.h"

namespace stiefel {

/// Solves UΛ − ΛUᵀ = hM for U = J_D⁻¹(hM) in N dimensions, on the branch that starts at the
/// identity. Sweeps in the rotation form (RotationN) start from the solution extrapolated from the
/// last steps. Bodies with a λ < 0 and steps with h‖Ω‖ near 1 or more are solved in the Cayley
/// form, by sweeps or by Newton's method. Λ and h are divided by a power of two that makes the
/// largest λ about 1: U depends only on the ratio Λ : h, and products of two λ then never overflow.
class JDInverseN {
 public:
  using State = Accumulator<Eigen::MatrixXd>;
  /// At h‖Ω‖ = 0.2 each of the 14 points saves half a sweep; more points would only add rounding
  /// errors.
  using Memory = History<double, 14>;

  JDInverseN(const Eigen::VectorXd& lambda, double h);
  JDInverseN(JDInverseN&&) noexcept;
  ~JDInverseN();

  /// Returns the memory before the first step.
  Memory memory(const auto&...) const { return {packed_size_, 1}; }

  /// Finds U. Returns false where the branch has no solution, or the iterations do not find it.
  bool solve(const State& x, const Memory& memory);

  /// Finds U for the step t·h, starting from the solution found last, or from U = I after
  /// `restart`.
  bool continue_to(const State& x, double t);
  void restart();

  /// Sets Q ← QU, M ← UᵀMU. When it is stopped, x and the memory are unchanged.
  void transport(State& x, Memory& memory);

  /// Returns U − I of the last `transport`, relatively accurate.
  const Eigen::MatrixXd& U_minus_I();

 private:
  struct Forms;
  std::unique_ptr<Forms> forms_;
  Eigen::Index packed_size_;
};

}  // namespace stiefel
