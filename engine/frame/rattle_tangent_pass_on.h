#pragma once

#include <algorithm>

#include "engine/frame/rattle_tangent_pass.h"
#include "engine/frame/tile.h"
#include "engine/numbers/pack.h"

namespace stiefel {

/// Computes RattleTangentPass by packs of columns. `rows` is n for small n, else any_rows.
template <int rows_, Isa isa>
class RattleTangentPassOn final : public RattleTangentPass {
 public:
  explicit RattleTangentPassOn(std::ptrdiff_t n) : n_(n), local_{Block(n), Block(n)} {}

  void step(const RattleColumns& at, double h, const double* B, const double* Z) override {
    for (std::ptrdiff_t t = 0; t < tiles(at); ++t) {
      const std::ptrdiff_t packs = filled(at, t);
      const Rows Q = of(at.Q, t), S = of(at.S, t);
      Rows half = of(at.half, t), next = of(at.next, t), G1 = of(at.G1, t), end = of(at.end, t),
           V1 = of(at.V1, t);
      const P* const w = weights(at, t);
      for (std::ptrdiff_t k = 0; k < packs; ++k) {
        for (std::ptrdiff_t i = 0; i < n(); ++i) {
          half[i][k] = S[i][k] + times(B, i, Q, k);
          next[i][k] = Q[i][k] + h * (half[i][k] * w[k]);
          G1[i][k] = next[i][k] * w[k];
        }
        for (std::ptrdiff_t i = 0; i < n(); ++i) {
          end[i][k] = half[i][k] + times(Z, i, next, k);
          V1[i][k] = end[i][k] * w[k];
        }
      }
    }
  }

  void begin(const RattleColumns& at, const RattleVector& x, double h, const double* B,
             double* R) override {
    Sum sum(n(), R);
    for (std::ptrdiff_t t = 0; t < tiles(at); ++t) {
      const std::ptrdiff_t packs = filled(at, t);
      const Rows dQ = of(x.Q, t), dS = of(x.S, t);
      Rows next = of(at.next, t), work = of(x.work, t), W = local(0);
      const P* const w = weights(at, t);
      for (std::ptrdiff_t k = 0; k < packs; ++k) {
        const P hw = h * w[k];
        for (std::ptrdiff_t i = 0; i < n(); ++i) {
          work[i][k] = times(B, i, dQ, k);
          W[i][k] = dQ[i][k] + hw * (dS[i][k] + work[i][k]);
        }
      }
      if (x.by_inverse) add_shift(at, x, h, t, W);
      Product::template add<false>(W, next, n(), packs, sum);
    }
    sum.finish(false, n());
  }

  void move_Q(const RattleColumns& at, const RattleVector& x, double h, const double* dB,
              const double* Z, double* R) override {
    x.Q_carry ? move_Q_in<true>(at, x, h, dB, Z, R) : move_Q_in<false>(at, x, h, dB, Z, R);
  }

  void move_S(const RattleColumns& at, const RattleVector& x, const double* dZ) override {
    x.S_carry ? move_S_in<true>(at, x, dZ) : move_S_in<false>(at, x, dZ);
  }

 private:
  using P = Pack<double, isa>;
  static constexpr std::ptrdiff_t packs_of_tile = TileRow::columns / P::lanes;
  /// The rows of a tile.
  struct Rows {
    static constexpr int rows = rows_;
    P* first;
    P* operator[](std::ptrdiff_t i) const { return first + packs_of_tile * i; }
  };
  using Block = Tile<P, rows_, packs_of_tile>;
  using Sum = TileSum<P, rows_>;
  /// The largest block that fits into the registers.
  static constexpr bool many_registers = isa == Isa::avx512;
  using Product = TileProduct<many_registers ? 4 : 1, many_registers ? 4 : 2>;

  std::ptrdiff_t n() const { return rows_ == any_rows ? n_ : rows_; }

  Rows of(const TileRow* x, std::ptrdiff_t tile) const {
    return {reinterpret_cast<P*>(const_cast<TileRow*>(x + n() * tile))};
  }
  Rows local(int which) { return {local_[which][0]}; }
  static std::ptrdiff_t tiles(const RattleColumns& at) {
    return (at.columns + TileRow::columns - 1) / TileRow::columns;
  }
  /// Returns the packs of a tile that hold columns.
  static std::ptrdiff_t filled(const RattleColumns& at, std::ptrdiff_t tile) {
    const std::ptrdiff_t left = at.columns - tile * TileRow::columns;
    return std::min(packs_of_tile, (left + P::lanes - 1) / P::lanes);
  }
  static const P* weights(const RattleColumns& at, std::ptrdiff_t tile) {
    return reinterpret_cast<const P*>(at.inverse + tile);
  }

  /// Returns row i of the product of an n × n matrix with X, in pack k.
  [[gnu::always_inline]] P times(const double* M, std::ptrdiff_t i, const Rows& X,
                                 std::ptrdiff_t k) const {
    P sum = M[i] * X[0][k];
    for (std::ptrdiff_t l = 1; l < n(); ++l) sum = sum + M[i + n() * l] * X[l][k];
    return sum;
  }

  /// Adds hS_½δΛ⁻¹ + δh S_½Λ⁻¹.
  void add_shift(const RattleColumns& at, const RattleVector& x, double h, std::ptrdiff_t t,
                 Rows& W) const {
    const Rows half = of(at.half, t);
    const P *const w = weights(at, t), *const dw = reinterpret_cast<const P*>(x.by_inverse + t);
    for (std::ptrdiff_t k = 0; k < filled(at, t); ++k)
      for (std::ptrdiff_t i = 0; i < n(); ++i) W[i][k] += half[i][k] * (h * dw[k] + x.by_h * w[k]);
  }

  /// Sets value ← value + change, with the rounding error added to the carry, as PairSums does.
  template <bool compensated>
  [[gnu::always_inline]] static void add(P& value, P* carry, P change) {
    if constexpr (compensated) {
      change = *carry + change;
      const P sum = value + change, part = sum - value;
      *carry = (value - (sum - part)) + (change - part);
      value = sum;
    } else {
      value = value + change;
    }
  }

  template <bool compensated>
  void move_Q_in(const RattleColumns& at, const RattleVector& x, double h, const double* dB,
                 const double* Z, double* R) {
    Sum sum(n(), R);
    for (std::ptrdiff_t t = 0; t < tiles(at); ++t) {
      const std::ptrdiff_t packs = filled(at, t);
      const Rows Q = of(at.Q, t), dS = of(x.S, t), carry = of(x.Q_carry, compensated ? t : 0);
      Rows dQ = of(x.Q, t), work = of(x.work, t), step = local(0), half = local(1),
           G1 = of(at.G1, t), V1 = of(at.V1, t), next = of(at.next, t);
      const P* const w = weights(at, t);
      for (std::ptrdiff_t k = 0; k < packs; ++k) {
        const P hw = h * w[k];
        for (std::ptrdiff_t i = 0; i < n(); ++i) {
          work[i][k] += times(dB, i, Q, k);
          step[i][k] = hw * (dS[i][k] + work[i][k]);
        }
      }
      if (x.by_inverse) add_shift(at, x, h, t, step);
      for (std::ptrdiff_t k = 0; k < packs; ++k) {
        for (std::ptrdiff_t i = 0; i < n(); ++i)
          add<compensated>(dQ[i][k], compensated ? carry[i] + k : nullptr, step[i][k]);
        for (std::ptrdiff_t i = 0; i < n(); ++i) {
          work[i][k] += times(Z, i, dQ, k);
          half[i][k] = dS[i][k] + work[i][k];
        }
      }
      Product::template add<false>(dQ, V1, n(), packs, sum);
      Product::template add<false>(half, G1, n(), packs, sum);
      if (!x.by_inverse) continue;
      const Rows end = of(at.end, t);
      const P* const dw = reinterpret_cast<const P*>(x.by_inverse + t);
      for (std::ptrdiff_t k = 0; k < packs; ++k)
        for (std::ptrdiff_t i = 0; i < n(); ++i) step[i][k] = dw[k] * end[i][k];
      Product::template add<false>(step, next, n(), packs, sum);
    }
    sum.finish(false, n());
  }

  template <bool compensated>
  void move_S_in(const RattleColumns& at, const RattleVector& x, const double* dZ) {
    for (std::ptrdiff_t t = 0; t < tiles(at); ++t) {
      const std::ptrdiff_t packs = filled(at, t);
      const Rows next = of(at.next, t), work = of(x.work, t),
                 carry = of(x.S_carry, compensated ? t : 0);
      Rows dS = of(x.S, t);
      for (std::ptrdiff_t k = 0; k < packs; ++k)
        for (std::ptrdiff_t i = 0; i < n(); ++i)
          add<compensated>(dS[i][k], compensated ? carry[i] + k : nullptr,
                           work[i][k] + times(dZ, i, next, k));
    }
  }

  std::ptrdiff_t n_;
  Block local_[2];
};

template <Isa isa>
std::unique_ptr<RattleTangentPass> make_rattle_tangent_pass_on(std::ptrdiff_t n) {
  if (n == 2) return std::make_unique<RattleTangentPassOn<2, isa>>(n);
  if (n == 3) return std::make_unique<RattleTangentPassOn<3, isa>>(n);
  if (n == 4) return std::make_unique<RattleTangentPassOn<4, isa>>(n);
  return std::make_unique<RattleTangentPassOn<any_rows, isa>>(n);
}

}  // namespace stiefel
