#pragma once

#include "engine/frame/frame_moments.h"
#include "engine/frame/frame_pass.h"
#include "engine/frame/tile.h"
#include "engine/numbers/pack.h"

namespace stiefel {

/// The columns of a tile from whose products the moments are summed: Q, V = Q̇, G = QΛ⁻¹, H = VΛ⁻¹,
/// F = GΛ⁻¹. `rows` is n where n is small, else any_rows.
template <class Scalar, int rows, Isa isa>
struct MomentTiles {
  using P = Pack<Scalar, isa>;
  using Rows = Tile<P, rows, FramePass<Scalar>::width / P::lanes>;

  explicit MomentTiles(std::ptrdiff_t n) : Q(n), G(n), V(n), H(n), F(n) {}

  Rows Q, G, V, H, F;
};

/// Sums the moments over the tiles. It depends neither on the arithmetic nor on the form of the
/// state, so all passes with the same number of rows share this code.
template <class Scalar, int rows, Isa isa>
class MomentSums {
 public:
  using Tiles = MomentTiles<Scalar, rows, isa>;

  MomentSums(std::ptrdiff_t n, const FrameSums<Scalar>& out)
      : QQ0_(n, out.QQ[0]),
        QQ1_(n, out.QQ[1]),
        QQ2_(n, out.QQ[2]),
        QQ3_(n, out.QQ[3]),
        QV0_(n, out.QV[0]),
        QV1_(n, out.QV[1]),
        QV2_(n, out.QV[2]),
        VV0_(n, out.VV[0]),
        VV1_(n, out.VV[1]) {}

  /// Adds the first `filled` packs of the tiles, which have n rows.
  [[gnu::noinline]] void add(Tiles& x, std::ptrdiff_t any_n, std::ptrdiff_t filled) {
    const std::ptrdiff_t n = rows == any_rows ? any_n : rows;
    Product::template add<true>(x.Q, x.Q, n, filled, QQ0_);
    Product::template add<true>(x.G, x.Q, n, filled, QQ1_);
    Product::template add<true>(x.G, x.G, n, filled, QQ2_);
    Product::template add<true>(x.F, x.G, n, filled, QQ3_);
    Product::template add<false>(x.Q, x.V, n, filled, QV0_);
    Product::template add<false>(x.G, x.V, n, filled, QV1_);
    Product::template add<false>(x.G, x.H, n, filled, QV2_);
    Product::template add<true>(x.V, x.V, n, filled, VV0_);
    Product::template add<true>(x.H, x.V, n, filled, VV1_);
  }

  [[gnu::noinline]] void finish(std::ptrdiff_t any_n) {
    const std::ptrdiff_t n = rows == any_rows ? any_n : rows;
    for (Sum* sum : {&QQ0_, &QQ1_, &QQ2_, &QQ3_, &VV0_, &VV1_}) sum->finish(true, n);
    for (Sum* sum : {&QV0_, &QV1_, &QV2_}) sum->finish(false, n);
  }

 private:
  using Sum = TileSum<Pack<Scalar, isa>, rows>;
  /// Chooses the largest block that fits into the registers: 4 × 4, 1 × 4 or 1 × 2 elements.
  using Product = TileProduct<isa == Isa::avx512 ? 4 : 1, isa == Isa::baseline ? 2 : 4>;

  Sum QQ0_, QQ1_, QQ2_, QQ3_, QV0_, QV1_, QV2_, VV0_, VV1_;
};

}  // namespace stiefel
