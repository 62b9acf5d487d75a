#pragma once

#include <algorithm>

#include "engine/linalg/simd/four_rows.h"
#include "engine/maps/frames/frame_pass.h"
#include "engine/maps/frames/tile.h"

namespace stiefel {

/// FramePass by packs of columns, as many at a time as stay in the cache. `rows` is n for small n,
/// else any_rows.
template <class Scalar, Arithmetic arithmetic, Under under, int rows, Isa isa>
class FramePassOn final : public FramePass<Scalar> {
 public:
  explicit FramePassOn(std::ptrdiff_t n)
      : n_(n), Q_(n), S_(n), Q_carry_(n), S_carry_(n), kick_(n), G_(n), V_(n), H_(n), F_(n) {}

  void measure(const FrameColumns<Scalar>& x, const FrameSums<Scalar>& moments) override {
    pass(x, moments, [](std::ptrdiff_t, P) { return false; });
  }

  void advance(const FrameColumns<Scalar>& x, Scalar h, const Scalar* Y_h, const Scalar* Y1_h,
               const FrameSums<Scalar>& moments) override {
    pass(
        x, moments, [ =, this ](std::ptrdiff_t p, P w) __attribute__((always_inline)) {
          step(p, w, h, Y_h, Y1_h);
          return true;
        });
  }

 private:
  using P = Pack<Scalar, isa>;
  static constexpr std::ptrdiff_t width = FramePass<Scalar>::width;
  static constexpr bool compensated = arithmetic == Arithmetic::compensated;
  static constexpr bool qdot = under == Under::Qdot;
  using Rows = Tile<P, rows, width / P::lanes>;

  std::ptrdiff_t n() const { return rows == any_rows ? n_ : rows; }

  template <class Step>
  [[gnu::always_inline]] void pass(const FrameColumns<Scalar>& x, const FrameSums<Scalar>& moments,
                                   Step&& step_changes) {
    Sums sums(n(), moments);
    for (std::ptrdiff_t j = 0; j < x.count; j += width) {
      const std::ptrdiff_t there = std::min(width, x.count - j);
      std::ptrdiff_t p = 0;
      for (std::ptrdiff_t k = 0; k < there; k += P::lanes, ++p) {
        const std::ptrdiff_t columns = std::min<std::ptrdiff_t>(P::lanes, there - k);
        const P w = P::load(x.inverse + j + k);
        prefetch(x, j + k + width);
        move<true>(x, j + k, columns, p);
        if (step_changes(p, w)) move<false>(x, j + k, columns, p);
        for (std::ptrdiff_t i = 0; i < n(); ++i) {
          G_[i][p] = Q_[i][p] * w;
          V_[i][p] = qdot ? S_[i][p] : S_[i][p] * w;
          H_[i][p] = V_[i][p] * w;
          F_[i][p] = G_[i][p] * w;
        }
      }
      sums.add(*this, p);
    }
    sums.finish(n());
  }

  /// Prefetches the columns of the next tile, from column j on. Does nothing past the end.
  [[gnu::always_inline]] void prefetch(const FrameColumns<Scalar>& x, std::ptrdiff_t j) {
    constexpr std::ptrdiff_t line = std::max<std::ptrdiff_t>(1, 64 / sizeof(Scalar));
    for (std::ptrdiff_t k = 0; k < 2 * n() * P::lanes; k += line) {
      __builtin_prefetch(x.value + j * 2 * n() + k, 1);
      if constexpr (compensated) __builtin_prefetch(x.carry + j * 2 * n() + k, 1);
    }
  }

  /// Computes the step for pack p of the tiles, from the multipliers divided by h.
  [[gnu::always_inline]] void step(std::ptrdiff_t p, P w, Scalar h, const Scalar* Y_h,
                                   const Scalar* Y1_h) {
    for (std::ptrdiff_t i = 0; i < n(); ++i) kick_[i][p] = times_Q(Y_h + i, p);
    for (std::ptrdiff_t i = 0; i < n(); ++i) {
      P kick = qdot ? kick_[i][p] * w : kick_[i][p];
      if constexpr (compensated) kick = S_carry_[i][p] + kick;
      const P change = h * (S_[i][p] + kick);
      add(Q_[i][p], Q_carry_[i][p], qdot ? change : change * w);
    }
    for (std::ptrdiff_t i = 0; i < n(); ++i) {
      const P change = kick_[i][p] + times_Q(Y1_h + i, p);
      add(S_[i][p], S_carry_[i][p], qdot ? change * w : change);
    }
  }

  /// The product of one row of an n × n matrix, which starts at `Y`, with Q.
  [[gnu::always_inline]] P times_Q(const Scalar* Y, std::ptrdiff_t p) {
    P sum = Y[0] * Q_[0][p];
    for (std::ptrdiff_t l = 1; l < n(); ++l) sum = sum + Y[n() * l] * Q_[l][p];
    return sum;
  }

  /// value ← value + change, with the rounding error added to the carry, as in Accumulator.
  [[gnu::always_inline]] static void add(P& value, P& carry, P change) {
    if constexpr (compensated) {
      change = change + carry;
      const P sum = value + change;
      const P seen = sum - value;
      carry = (value - (sum - seen)) + (change - seen);
      value = sum;
    } else {
      value = value + change;
    }
  }

  /// Copies between pack p of the tiles and `columns` columns of x from column j on. Lanes without
  /// a column are set to zero.
  template <bool load>
  [[gnu::always_inline]] void move(const FrameColumns<Scalar>& x, std::ptrdiff_t j,
                                   std::ptrdiff_t columns, std::ptrdiff_t p) {
    const std::ptrdiff_t height = 2 * n();
    move_rows<load>(x.value + j * height, columns, Q_, p);
    move_rows<load>(x.value + j * height + n(), columns, S_, p);
    if constexpr (compensated) {
      move_rows<load>(x.carry + j * height, columns, Q_carry_, p);
      move_rows<load>(x.carry + j * height + n(), columns, S_carry_, p);
    }
  }

  template <bool load>
  [[gnu::always_inline]] void move_rows(Scalar* x, std::ptrdiff_t columns, Rows& tile,
                                        std::ptrdiff_t p) {
    const std::ptrdiff_t height = 2 * n();
    std::ptrdiff_t i = 0;
    if (columns == P::lanes) {
      if constexpr (std::is_same_v<Scalar, double> && FourRows<isa>::fast)
        for (; i + 4 <= n(); i += 4) {
          P four[4];
          if constexpr (load) {
            FourRows<isa>::load(x + i, height, four);
            for (int k = 0; k < 4; ++k) tile[i + k][p] = four[k];
          } else {
            for (int k = 0; k < 4; ++k) four[k] = tile[i + k][p];
            FourRows<isa>::store(four, x + i, height);
          }
        }
      for (; i < n(); ++i) {
        if constexpr (load)
          tile[i][p] = P::gather(x + i, height);
        else
          tile[i][p].scatter(x + i, height);
      }
    } else {
      for (; i < n(); ++i) {
        Scalar lanes[P::lanes] = {};
        if constexpr (load) {
          for (int k = 0; k < columns; ++k) lanes[k] = x[i + k * height];
          tile[i][p] = P::load(lanes);
        } else {
          tile[i][p].store(lanes);
          for (int k = 0; k < columns; ++k) x[i + k * height] = lanes[k];
        }
      }
    }
  }

  /// The moments of the columns so far.
  struct Sums {
    using Sum = TileSum<P, rows>;
    /// The largest block that fits in the registers.
    using Product = TileProduct<isa == Isa::avx512 ? 4 : 1, isa == Isa::avx512 ? 4 : 2>;
    Sum QQ0, QQ1, QQ2, QQ3, QV0, QV1, QV2, VV0, VV1;

    Sums(std::ptrdiff_t n, const FrameSums<Scalar>& out)
        : QQ0(n, out.QQ[0]),
          QQ1(n, out.QQ[1]),
          QQ2(n, out.QQ[2]),
          QQ3(n, out.QQ[3]),
          QV0(n, out.QV[0]),
          QV1(n, out.QV[1]),
          QV2(n, out.QV[2]),
          VV0(n, out.VV[0]),
          VV1(n, out.VV[1]) {}

    [[gnu::always_inline]] void add(FramePassOn& x, std::ptrdiff_t filled) {
      const std::ptrdiff_t n = x.n();
      Product::template add<true>(x.Q_, x.Q_, n, filled, QQ0);
      Product::template add<true>(x.G_, x.Q_, n, filled, QQ1);
      Product::template add<true>(x.G_, x.G_, n, filled, QQ2);
      Product::template add<true>(x.F_, x.G_, n, filled, QQ3);
      Product::template add<false>(x.Q_, x.V_, n, filled, QV0);
      Product::template add<false>(x.G_, x.V_, n, filled, QV1);
      Product::template add<false>(x.G_, x.H_, n, filled, QV2);
      Product::template add<true>(x.V_, x.V_, n, filled, VV0);
      Product::template add<true>(x.H_, x.V_, n, filled, VV1);
    }

    void finish(std::ptrdiff_t n) {
      for (Sum* sum : {&QQ0, &QQ1, &QQ2, &QQ3, &VV0, &VV1}) sum->finish(true, n);
      for (Sum* sum : {&QV0, &QV1, &QV2}) sum->finish(false, n);
    }
  };

  std::ptrdiff_t n_;
  Rows Q_, S_, Q_carry_, S_carry_, kick_, G_, V_, H_, F_;
};

template <class Scalar, Arithmetic arithmetic, Under under, Isa isa>
std::unique_ptr<FramePass<Scalar>> make_frame_pass_on(std::ptrdiff_t n) {
  const auto make = [n]<int rows>() {
    return std::make_unique<FramePassOn<Scalar, arithmetic, under, rows, isa>>(n);
  };
  switch (n) {
    case 1:
      return make.template operator()<1>();
    case 2:
      return make.template operator()<2>();
    case 3:
      return make.template operator()<3>();
    case 4:
      return make.template operator()<4>();
    default:
      return make.template operator()<any_rows>();
  }
}

// Compiled once for each instruction set, from frame_pass.cc.in.
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::compensated, Under::S, Isa::baseline>(std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::plain, Under::S, Isa::baseline>(std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::compensated, Under::Qdot, Isa::baseline>(std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::plain, Under::Qdot, Isa::baseline>(std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::compensated, Under::S, Isa::avx2>(std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::plain, Under::S, Isa::avx2>(std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::compensated, Under::Qdot, Isa::avx2>(std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::plain, Under::Qdot, Isa::avx2>(std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::compensated, Under::S, Isa::avx512>(std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::plain, Under::S, Isa::avx512>(std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::compensated, Under::Qdot, Isa::avx512>(std::ptrdiff_t);
extern template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::plain, Under::Qdot, Isa::avx512>(std::ptrdiff_t);

}  // namespace stiefel
