#pragma once

#include <cstddef>
#include <memory>

#include "engine/numbers/isa.h"

namespace stiefel {

/// A row of 64 columns of an n × N matrix. A matrix is stored tile by tile of n such rows, with
/// zeros behind column N.
struct alignas(64) TileRow {
  static constexpr std::ptrdiff_t columns = 64;
  double x[columns];
};

/// The values of a step of RATTLE, in the letters of RattleTangent (rattle_tangent.cc).
struct RattleColumns {
  std::ptrdiff_t columns;              ///< N
  const TileRow* inverse;              ///< Λ⁻¹
  TileRow *Q, *S, *half, *next, *end;  ///< Q, S, S_½, Q′, S′
  TileRow *G1, *V1;                    ///< Q′Λ⁻¹, S′Λ⁻¹
};

/// A tangent vector (δQ, δS), and along it δΛ⁻¹, null where it is zero, and δh.
struct RattleVector {
  TileRow *Q, *S, *Q_carry, *S_carry;  ///< no carries in plain arithmetic
  const TileRow* by_inverse;
  double by_h;
  TileRow* work;  ///< n × N
};

/// The passes over the columns in a step of RATTLE and of its derivative, which the instruction
/// sets share. Matrices are n × n, column by column.
class RattleTangentPass {
 public:
  virtual ~RattleTangentPass();

  /// Sets S_½ = S + BQ, Q′ = Q + hS_½Λ⁻¹, S′ = S_½ + ZQ′.
  virtual void step(const RattleColumns& at, double h, const double* B, const double* Z) = 0;

  /// With w = δS + BδQ, sets R = (δQ + hwΛ⁻¹ + hS_½δΛ⁻¹ + δh S_½Λ⁻¹)Q′ᵀ.
  virtual void begin(const RattleColumns& at, const RattleVector& x, double h, const double* B,
                     double* R) = 0;
  /// Moves δQ, and sets R = δQ′V′ᵀ + Q′δV′ᵀ without δZ, V′ = S′Λ⁻¹.
  virtual void move_Q(const RattleColumns& at, const RattleVector& x, double h, const double* dB,
                      const double* Z, double* R) = 0;
  /// Moves δS.
  virtual void move_S(const RattleColumns& at, const RattleVector& x, const double* dZ) = 0;
};

/// Returns the passes for n rows compiled for `isa`.
template <Isa isa>
std::unique_ptr<RattleTangentPass> make_rattle_tangent_pass_on(std::ptrdiff_t n);

// Compiled once for each instruction set, in rattle_tangent_pass.cc.in.
extern template std::unique_ptr<RattleTangentPass> make_rattle_tangent_pass_on<Isa::baseline>(
    std::ptrdiff_t);
extern template std::unique_ptr<RattleTangentPass> make_rattle_tangent_pass_on<Isa::avx2>(
    std::ptrdiff_t);
extern template std::unique_ptr<RattleTangentPass> make_rattle_tangent_pass_on<Isa::avx512>(
    std::ptrdiff_t);

/// Returns the passes compiled for the widest instruction set of this machine.
inline std::unique_ptr<RattleTangentPass> make_rattle_tangent_pass(std::ptrdiff_t n) {
#ifdef STIEFEL_X86_64
  if (widest_isa() == Isa::avx512) return make_rattle_tangent_pass_on<Isa::avx512>(n);
  if (widest_isa() == Isa::avx2) return make_rattle_tangent_pass_on<Isa::avx2>(n);
#endif
  return make_rattle_tangent_pass_on<Isa::baseline>(n);
}

}  // namespace stiefel
