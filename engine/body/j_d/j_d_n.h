#pragma once

#include <optional>

#include "engine/body/j_d/cayley_n.h"
#include "engine/body/j_d/deviation_n.h"
#include "engine/body/j_d/rotation_n.h"
#include "engine/dense/history.h"

namespace stiefel {

/// Solves UΛ − ΛUᵀ = hM for U = J_D⁻¹(hM) in N dimensions, on the branch that starts at the
/// identity. Sweeps in the deviation form start from the solution extrapolated from the last steps;
/// where they converge slowly, Newton's method in the Cayley form follows. Where Λ is spread wide,
/// large bodies are solved in the rotation form (RotationN), and small bodies, bodies with a
/// λ < 0 and steps with h‖Ω‖ near 1 in the Cayley form. Λ and h are divided by a power of two that
/// makes the largest λ about 1: U depends only on the ratio Λ : h, and products of two λ then
/// never overflow.
template <class Scalar>
class JDInverseN {
 public:
  using State = Accumulator<Matrix<Scalar>>;
  /// At h‖Ω‖ = 0.2 each of the 14 points saves half a sweep; more points would only add rounding
  /// errors.
  using Memory = History<Scalar, 14>;

  JDInverseN(const Vector<Scalar>& lambda, Scalar h)
      : JDInverseN(lambda, h, binary_unit<Scalar>(lambda.maxCoeff())) {}

  Memory memory() const {
    return wide_spread_ && !rotation_ ? Memory(N_, N_) : Memory(N_ * (N_ + 1) / 2, 1);
  }

  /// Finds U. Returns false where the branch has no solution, or the iterations do not find it.
  bool solve(const State& x, const Memory& memory);

  /// Finds U for the step t·h, starting from the solution found last, or from U = I after
  /// `restart`.
  bool continue_to(const State& x, double t);
  void restart() { cayley_.C().setZero(); }

  /// Sets Q ← QU, M ← UᵀMU. When it is stopped, x and the memory are unchanged.
  void transport(State& x, Memory& memory);

  /// Returns U − I of the last `transport`, relatively accurate.
  const Matrix<Scalar>& U_minus_I() {
    if (in_rotation_form_) return rotation_->U_minus_I();
    return wide_spread_ ? cayley_.U_minus_I() : deviation_.U_minus_I();
  }

 private:
  JDInverseN(const Vector<Scalar>& lambda, Scalar h, Scalar unit);

  /// Largest λ_max/λ_min for which the deviation form keeps its digits.
  static constexpr Scalar widest = 64;
  /// Smallest N whose steps take less time in the rotation form than in the Cayley form.
  static constexpr Eigen::Index least_rotation = 5;

  bool take_over() {
    if (!wide_spread_) deviation_.set(cayley_.deviation(), K_);
    return true;
  }

  Scalar h_;
  Eigen::Index N_;
  bool wide_spread_, in_rotation_form_ = false;
  DeviationN<Scalar> deviation_;
  CayleyN<Scalar> cayley_;
  std::optional<RotationN<Scalar>> rotation_;
  Matrix<Scalar> K_, found_;
};

template <class Scalar>
JDInverseN<Scalar>::JDInverseN(const Vector<Scalar>& lambda, Scalar h, Scalar unit)
    : h_(h / unit),
      N_(lambda.size()),
      wide_spread_(!(lambda.minCoeff() * widest > lambda.maxCoeff())),
      deviation_(lambda.head(wide_spread_ ? 0 : N_) / unit, h_),
      cayley_(lambda / unit, h_),
      K_(N_, N_),
      found_(N_, N_) {
  if (wide_spread_ && N_ >= least_rotation && !(lambda.minCoeff() < 0))
    rotation_.emplace(lambda / unit, h_);
}

template <class Scalar>
bool JDInverseN<Scalar>::solve(const State& x, const Memory& memory) {
  const auto times_h = [&](Eigen::Index begin, Eigen::Index end) {
    auto columns = K_.middleCols(begin, end - begin);
    columns = h_ * x.value.bottomRows(N_).middleCols(begin, end - begin);
    return Scalar(columns.allFinite() ? 0 : 1);
  };
  if (largest_in_column_ranges<Scalar>(N_, static_cast<double>(N_), times_h) > 0) return false;
  in_rotation_form_ = false;
  if (rotation_) {
    if (!memory.predict(rotation_->S())) rotation_->S().setZero();
    in_rotation_form_ = rotation_->solve(K_, x.compensated);
    if (in_rotation_form_) return true;
  }
  if (wide_spread_) {
    if (rotation_ || !memory.predict(cayley_.C())) cayley_.start(K_);
    if (cayley_.fixed_point(K_)) return true;
  } else {
    if (!memory.predict(deviation_.R())) deviation_.R().setZero();
    if (deviation_.sweep(K_, x.compensated)) return true;
  }
  cayley_.start(K_);
  return cayley_.newton(K_) && take_over();
}

template <class Scalar>
bool JDInverseN<Scalar>::continue_to(const State& x, double t) {
  K_ = (static_cast<Scalar>(t) * h_) * x.value.bottomRows(N_);
  found_ = cayley_.C();
  if (cayley_.newton(K_)) return take_over();
  cayley_.C() = found_;
  return false;
}

template <class Scalar>
void JDInverseN<Scalar>::transport(State& x, Memory& memory) {
  if (in_rotation_form_) {
    rotation_->transport(x);
    memory.push(rotation_->S());
  } else if (!wide_spread_) {
    deviation_.transport(x);
    memory.push(deviation_.R());
  } else {
    cayley_.transport(x);
    if (!rotation_) return memory.push(cayley_.C());
    rotation_->set(cayley_.U_minus_I());
    memory.push(rotation_->S());
  }
}

// Compiled once, in j_d_n.cc.
extern template class JDInverseN<double>;

}  // namespace stiefel
