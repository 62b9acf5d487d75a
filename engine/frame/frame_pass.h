#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "engine/numbers/compensated.h"
#include "engine/numbers/isa.h"

namespace stiefel {

/// Pointers to the n × n moments of a state, stored column after column.
template <class Scalar>
struct FrameSums {
  Scalar *QQ[4], *QV[3], *VV[2];
};

/// The moments of a state on V(n, N), which determine a step: n × n sums over its N columns, with V
/// = Q̇ = SΛ⁻¹,
///
///     QQ[p] = QΛ⁻ᵖQᵀ, p = 0..3,   QV[p] = QΛ⁻ᵖVᵀ, p = 0..2,   VV[p] = VΛ⁻ᵖVᵀ, p = 0, 1.
template <class Scalar>
struct FrameMoments {
  std::array<Matrix<Scalar>, 4> QQ;
  std::array<Matrix<Scalar>, 3> QV;
  std::array<Matrix<Scalar>, 2> VV;

  explicit FrameMoments(Eigen::Index n) {
    each([n](Matrix<Scalar>& sum) { sum.setZero(n, n); });
  }

  template <class Visitor>
  void each(Visitor&& visit) {
    for (auto& sum : QQ) visit(sum);
    for (auto& sum : QV) visit(sum);
    for (auto& sum : VV) visit(sum);
  }

  FrameMoments& operator+=(const FrameMoments& other) {
    for (std::size_t p = 0; p < QQ.size(); ++p) QQ[p] += other.QQ[p];
    for (std::size_t p = 0; p < QV.size(); ++p) QV[p] += other.QV[p];
    for (std::size_t p = 0; p < VV.size(); ++p) VV[p] += other.VV[p];
    return *this;
  }

  FrameSums<Scalar> sums() {
    return {{QQ[0].data(), QQ[1].data(), QQ[2].data(), QQ[3].data()},
            {QV[0].data(), QV[1].data(), QV[2].data()},
            {VV[0].data(), VV[1].data()}};
  }

  bool finite() const { return QQ[3].allFinite() && QV[2].allFinite() && VV[1].allFinite(); }
};

/// The columns of a state on V(n, N) in memory, 2n numbers each.
template <class Scalar>
struct FrameColumns {
  Scalar* value;
  Scalar* carry;          ///< null in plain arithmetic
  const Scalar* inverse;  ///< Λ⁻¹, followed by `FramePass::width` zeros
  std::ptrdiff_t count;   ///< N
};

/// The pass over the columns of a state in one step of RattleStiefel, a few columns at a time. From
/// Y/h and Y′/h `advance` computes the new state and its moments:
///
///     Q′ = Q + h(S + (Y/h)Q)Λ⁻¹,   S′ = S + (Y/h)Q + (Y′/h)Q′,
///
/// or without multipliers the moments of the state as it is. The pass holds nothing of size N.
template <class Scalar>
class FramePass {
 public:
  static constexpr std::ptrdiff_t width = 64;

  virtual ~FramePass() = default;
  virtual void advance(const FrameColumns<Scalar>& x, Scalar h, const Scalar* Y_h,
                       const Scalar* Y1_h, const FrameSums<Scalar>& moments) = 0;
};

/// Returns the pass for n rows compiled for `isa`. Scalars other than double need
/// frame_pass_on.h, and have no code specialised for few rows.
template <class Scalar, Isa isa>
std::unique_ptr<FramePass<Scalar>> make_frame_pass_on(Arithmetic arithmetic, std::ptrdiff_t n);

/// Returns the pass for n rows compiled for the widest instruction set of this machine.
template <class Scalar>
std::unique_ptr<FramePass<Scalar>> make_frame_pass(Arithmetic arithmetic, std::ptrdiff_t n) {
#ifdef STIEFEL_X86_64
  if constexpr (std::is_same_v<Scalar, double>) {
    if (widest_isa() == Isa::avx512) return make_frame_pass_on<Scalar, Isa::avx512>(arithmetic, n);
    if (widest_isa() == Isa::avx2) return make_frame_pass_on<Scalar, Isa::avx2>(arithmetic, n);
  }
#endif
  return make_frame_pass_on<Scalar, Isa::baseline>(arithmetic, n);
}

extern template class FramePass<double>;

// Compiled once for each instruction set, in frame_pass.cc.in.
extern template std::unique_ptr<FramePass<double>> make_frame_pass_on<double, Isa::baseline>(
    Arithmetic, std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>> make_frame_pass_on<double, Isa::avx2>(
    Arithmetic, std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>> make_frame_pass_on<double, Isa::avx512>(
    Arithmetic, std::ptrdiff_t);

}  // namespace stiefel
