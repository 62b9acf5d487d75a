#pragma once

#include <algorithm>

#include "engine/frame/frame_pass.h"
#include "engine/frame/moment_sums.h"
#include "engine/numbers/four_rows.h"

namespace stiefel {

/// Computes FramePass by packs of columns, in tiles of as many columns as stay in the cache. `rows`
/// is n for small n, else any_rows.
template <class Scalar, int rows, Isa isa>
class FramePassOn final : public FramePass<Scalar> {
 public:
  FramePassOn(Arithmetic arithmetic, std::ptrdiff_t n)
      : compensated_(arithmetic == Arithmetic::compensated),
        n_(n),
        tiles_(n),
        S_(n),
        Q_carry_(n),
        S_carry_(n),
        kick_(n) {}

  void advance(const FrameColumns<Scalar>& x, Scalar h, const Scalar* Y_h, const Scalar* Y1_h,
               const FrameSums<Scalar>& moments) override {
    compensated_ ? pass<true>(x, h, Y_h, Y1_h, moments) : pass<false>(x, h, Y_h, Y1_h, moments);
  }

 private:
  using P = Pack<Scalar, isa>;
  static constexpr std::ptrdiff_t width = FramePass<Scalar>::width;
  using Rows = typename MomentTiles<Scalar, rows, isa>::Rows;

  std::ptrdiff_t n() const { return rows == any_rows ? n_ : rows; }

  template <bool compensated>
  void pass(const FrameColumns<Scalar>& x, Scalar h, const Scalar* Y_h, const Scalar* Y1_h,
            const FrameSums<Scalar>& moments) {
    MomentSums<Scalar, rows, isa> sums(n(), moments);
    auto& [Q, G, V, H, F] = tiles_;
    for (std::ptrdiff_t j = 0; j < x.count; j += width) {
      const std::ptrdiff_t there = std::min(width, x.count - j);
      std::ptrdiff_t p = 0;
      for (std::ptrdiff_t k = 0; k < there; k += P::lanes, ++p) {
        const std::ptrdiff_t columns = std::min<std::ptrdiff_t>(P::lanes, there - k);
        const P w = P::load(x.inverse + j + k);
        prefetch<compensated>(x, j + k + width);
        move<true, compensated>(x, j + k, columns, p);
        if (Y_h) {
          step<compensated>(p, w, h, Y_h, Y1_h);
          move<false, compensated>(x, j + k, columns, p);
        }
        for (std::ptrdiff_t i = 0; i < n(); ++i) {
          G[i][p] = Q[i][p] * w;
          V[i][p] = S_[i][p] * w;
          H[i][p] = V[i][p] * w;
          F[i][p] = G[i][p] * w;
        }
      }
      sums.add(tiles_, n(), p);
    }
    sums.finish(n());
  }

  /// Prefetches the columns of the next tile, from column j on. Does nothing past the end.
  template <bool compensated>
  [[gnu::always_inline]] void prefetch(const FrameColumns<Scalar>& x, std::ptrdiff_t j) {
    constexpr std::ptrdiff_t line = std::max<std::ptrdiff_t>(1, 64 / sizeof(Scalar));
    for (std::ptrdiff_t k = 0; k < 2 * n() * P::lanes; k += line) {
      __builtin_prefetch(x.value + j * 2 * n() + k, 1);
      if constexpr (compensated) __builtin_prefetch(x.carry + j * 2 * n() + k, 1);
    }
  }

  /// Computes the step for pack p of the tiles, from the multipliers divided by h.
  template <bool compensated>
  [[gnu::always_inline]] void step(std::ptrdiff_t p, P w, Scalar h, const Scalar* Y_h,
                                   const Scalar* Y1_h) {
    for (std::ptrdiff_t i = 0; i < n(); ++i) kick_[i][p] = times_Q(Y_h + i, p);
    for (std::ptrdiff_t i = 0; i < n(); ++i) {
      P kick = kick_[i][p];
      if constexpr (compensated) kick = S_carry_[i][p] + kick;
      const P change = h * (S_[i][p] + kick);
      add<compensated>(tiles_.Q[i][p], Q_carry_[i][p], change * w);
    }
    for (std::ptrdiff_t i = 0; i < n(); ++i) {
      add<compensated>(S_[i][p], S_carry_[i][p], kick_[i][p] + times_Q(Y1_h + i, p));
    }
  }

  /// Returns the product of one row of an n × n matrix, which starts at `Y`, with Q.
  [[gnu::always_inline]] P times_Q(const Scalar* Y, std::ptrdiff_t p) {
    P sum = Y[0] * tiles_.Q[0][p];
    for (std::ptrdiff_t l = 1; l < n(); ++l) sum = sum + Y[n() * l] * tiles_.Q[l][p];
    return sum;
  }

  /// Sets value ← value + change, with the rounding error added to the carry, as Accumulator does.
  template <bool compensated>
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
  template <bool load, bool compensated>
  [[gnu::always_inline]] void move(const FrameColumns<Scalar>& x, std::ptrdiff_t j,
                                   std::ptrdiff_t columns, std::ptrdiff_t p) {
    const std::ptrdiff_t height = 2 * n();
    move_rows<load>(x.value + j * height, columns, tiles_.Q, p);
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

  bool compensated_;
  std::ptrdiff_t n_;
  MomentTiles<Scalar, rows, isa> tiles_;
  Rows S_, Q_carry_, S_carry_, kick_;
};

template <class Scalar, Isa isa>
std::unique_ptr<FramePass<Scalar>> make_frame_pass_on(Arithmetic arithmetic, std::ptrdiff_t n) {
  const auto of_rows = [&]<int rows>() -> std::unique_ptr<FramePass<Scalar>> {
    return std::make_unique<FramePassOn<Scalar, rows, isa>>(arithmetic, n);
  };
  if constexpr (std::is_same_v<Scalar, double>) {
    if (n == 1) return of_rows.template operator()<1>();
    if (n == 2) return of_rows.template operator()<2>();
    if (n == 3) return of_rows.template operator()<3>();
    if (n == 4) return of_rows.template operator()<4>();
  }
  return of_rows.template operator()<any_rows>();
}

}  // namespace stiefel
