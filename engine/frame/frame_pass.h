#pragma once

#include <cstddef>
#include <memory>

#include "engine/frame/frame_moments.h"
#include "engine/numbers/compensated.h"
#include "engine/numbers/isa.h"

namespace stiefel {

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
