#pragma once

#include <algorithm>
#include <vector>

#include "engine/frame/frame_pass.h"
#include "engine/numbers/four_rows.h"
#include "engine/numbers/pack.h"

namespace stiefel {

/// Marks a template for any number of rows.
inline constexpr int any_rows = -1;

/// A few columns of a matrix with n rows, stored by rows, with `packs` packs in each row.
template <class P, int n, std::ptrdiff_t packs>
class Tile {
 public:
  static constexpr int rows = n;
  explicit Tile(std::ptrdiff_t) {}
  P* operator[](std::ptrdiff_t i) { return rows_[i]; }

 private:
  P rows_[n][packs];
};
template <class P, std::ptrdiff_t packs>
class Tile<P, any_rows, packs> {
 public:
  static constexpr int rows = any_rows;
  explicit Tile(std::ptrdiff_t n) : rows_(static_cast<std::size_t>(n * packs)) {}
  P* operator[](std::ptrdiff_t i) { return rows_.data() + i * packs; }

 private:
  std::vector<P> rows_;
};

/// Holds an n × n sum of products from tile to tile, and writes it at the end, column after column.
/// For few rows the sum over the lanes is taken only at the end.
template <class P, int n>
class TileSum {
 public:
  TileSum(std::ptrdiff_t, typename P::Scalar* out) : out_(out) {
    for (auto& row : sum_)
      for (P& x : row) x = P::zero();
  }
  P load(std::ptrdiff_t i, std::ptrdiff_t j) const { return sum_[i][j]; }
  void store(std::ptrdiff_t i, std::ptrdiff_t j, P x) { sum_[i][j] = x; }
  void finish(bool symmetric, std::ptrdiff_t) const {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        out_[i + n * j] = (symmetric && j < i ? sum_[j][i] : sum_[i][j]).sum();
  }

 private:
  P sum_[n][n];
  typename P::Scalar* out_;
};
template <class P>
class TileSum<P, any_rows> {
 public:
  TileSum(std::ptrdiff_t n, typename P::Scalar* out) : n_(n), out_(out) {
    for (std::ptrdiff_t k = 0; k < n * n; ++k) out[k] = 0;
  }
  P load(std::ptrdiff_t, std::ptrdiff_t) const { return P::zero(); }
  void store(std::ptrdiff_t i, std::ptrdiff_t j, P x) { out_[i + n_ * j] += x.sum(); }
  void finish(bool symmetric, std::ptrdiff_t n) const {
    if (symmetric)
      for (std::ptrdiff_t i = 0; i < n; ++i)
        for (std::ptrdiff_t j = 0; j < i; ++j) out_[i + n * j] = out_[j + n * i];
  }

 private:
  std::ptrdiff_t n_;
  typename P::Scalar* out_;
};

/// Adds ABᵀ to sum, over the first `filled` packs of two tiles of n rows; for a symmetric product
/// only the elements on and above the diagonal. Works by blocks of R × C elements, which fit into
/// the registers.
template <int R, int C>
struct TileProduct {
  template <bool symmetric, class T, class Sum>
  [[gnu::always_inline]] static void add(T& A, T& B, std::ptrdiff_t n, std::ptrdiff_t filled,
                                         Sum& sum) {
    std::ptrdiff_t i = 0;
    if constexpr (fits<T>(R))
#pragma GCC unroll 4
      for (; i + R <= n; i += R) add_rows<R, symmetric>(A, B, i, n, filled, sum);
#pragma GCC unroll 4
    for (; i < n; ++i) add_rows<1, symmetric>(A, B, i, n, filled, sum);
  }

 private:
  template <class T>
  static constexpr bool fits(int rows) {
    return T::rows == any_rows || T::rows >= rows;
  }

  template <int r, bool symmetric, class T, class Sum>
  [[gnu::always_inline]] static void add_rows(T& A, T& B, std::ptrdiff_t i, std::ptrdiff_t n,
                                              std::ptrdiff_t filled, Sum& sum) {
    std::ptrdiff_t j = symmetric ? i : 0;
    if constexpr (symmetric && r > 1 && r == C) {
      add_block<r, C, true>(A, B, i, j, filled, sum);
      j += C;
    }
    if constexpr (fits<T>(C))
      for (; j + C <= n; j += C) add_block<r, C>(A, B, i, j, filled, sum);
    if constexpr (fits<T>(2) && C > 2)
      for (; j + 2 <= n; j += 2) add_block<r, 2>(A, B, i, j, filled, sum);
    for (; j < n; ++j) add_block<r, 1>(A, B, i, j, filled, sum);
  }

  /// Of a block on the diagonal, the elements on and above it.
  template <int r, int c, bool on_diagonal = false, class T, class Sum>
  [[gnu::always_inline]] static void add_block(T& A, T& B, std::ptrdiff_t i, std::ptrdiff_t j,
                                               std::ptrdiff_t filled, Sum& sum) {
    const auto skipped = [](int k, int l) { return on_diagonal && k > l; };
    decltype(sum.load(0, 0)) s[r][c];
#pragma GCC unroll 4
    for (int l = 0; l < c; ++l)
#pragma GCC unroll 4
      for (int k = 0; k < r; ++k)
        if (!skipped(k, l)) s[k][l] = sum.load(i + k, j + l);
    for (std::ptrdiff_t p = 0; p < filled; ++p)
#pragma GCC unroll 4
      for (int l = 0; l < c; ++l)
#pragma GCC unroll 4
        for (int k = 0; k < r; ++k)
          if (!skipped(k, l)) s[k][l] = s[k][l] + A[i + k][p] * B[j + l][p];
#pragma GCC unroll 4
    for (int l = 0; l < c; ++l)
#pragma GCC unroll 4
      for (int k = 0; k < r; ++k)
        if (!skipped(k, l)) sum.store(i + k, j + l, s[k][l]);
  }
};

/// The columns of a tile from whose products the moments are summed: Q, V = Q̇, G = QΛ⁻¹, H = VΛ⁻¹,
/// F = GΛ⁻¹. `rows` is n where n is small, else any_rows.
template <class Scalar, int rows, Isa isa>
struct MomentTiles {
  using P = Pack<Scalar, isa>;
  using Rows = Tile<P, rows, FramePass<Scalar>::width / P::lanes>;

  explicit MomentTiles(std::ptrdiff_t n) : Q(n), G(n), V(n), H(n), F(n) {}

  Rows Q, G, V, H, F;
};

/// Sums the moments over the tiles. It does not depend on the arithmetic, so that both share this
/// code.
template <class Scalar, int rows, Isa isa>
class MomentSums {
 public:
  MomentSums(std::ptrdiff_t n, const FrameSums<Scalar>& out)
      : QQ_{{n, out.QQ[0]}, {n, out.QQ[1]}, {n, out.QQ[2]}, {n, out.QQ[3]}},
        QV_{{n, out.QV[0]}, {n, out.QV[1]}, {n, out.QV[2]}},
        VV_{{n, out.VV[0]}, {n, out.VV[1]}} {}

  /// Adds the first `filled` packs of the tiles, which have n rows.
  [[gnu::noinline]] void add(MomentTiles<Scalar, rows, isa>& x, std::ptrdiff_t any_n,
                             std::ptrdiff_t filled) {
    const std::ptrdiff_t n = rows == any_rows ? any_n : rows;
    Product::template add<true>(x.Q, x.Q, n, filled, QQ_[0]);
    Product::template add<true>(x.G, x.Q, n, filled, QQ_[1]);
    Product::template add<true>(x.G, x.G, n, filled, QQ_[2]);
    Product::template add<true>(x.F, x.G, n, filled, QQ_[3]);
    Product::template add<false>(x.Q, x.V, n, filled, QV_[0]);
    Product::template add<false>(x.G, x.V, n, filled, QV_[1]);
    Product::template add<false>(x.G, x.H, n, filled, QV_[2]);
    Product::template add<true>(x.V, x.V, n, filled, VV_[0]);
    Product::template add<true>(x.H, x.V, n, filled, VV_[1]);
  }

  [[gnu::noinline]] void finish(std::ptrdiff_t any_n) {
    const std::ptrdiff_t n = rows == any_rows ? any_n : rows;
    for (Sum& sum : QQ_) sum.finish(true, n);
    for (Sum& sum : QV_) sum.finish(false, n);
    for (Sum& sum : VV_) sum.finish(true, n);
  }

 private:
  using Sum = TileSum<Pack<Scalar, isa>, rows>;
  /// Chooses the largest block that fits into the registers: 4 × 4, 1 × 4 or 1 × 2 elements.
  using Product = TileProduct<isa == Isa::avx512 ? 4 : 1, isa == Isa::baseline ? 2 : 4>;

  Sum QQ_[4], QV_[3], VV_[2];
};

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
    if constexpr (std::is_same_v<Scalar, double> && FourRows<isa>::fast)
      for (; columns == P::lanes && i + 4 <= n(); i += 4) {
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
