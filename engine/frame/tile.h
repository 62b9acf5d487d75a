#pragma once

#include <cstddef>
#include <vector>

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
      for (; i + R <= n; i += R) add_rows<R>(A, B, i, symmetric ? i : 0, n, filled, sum);
#pragma GCC unroll 4
    for (; i < n; ++i) add_rows<1>(A, B, i, symmetric ? i : 0, n, filled, sum);
  }

 private:
  template <class T>
  static constexpr bool fits(int rows) {
    return T::rows == any_rows || T::rows >= rows;
  }

  template <int r, class T, class Sum>
  [[gnu::always_inline]] static void add_rows(T& A, T& B, std::ptrdiff_t i, std::ptrdiff_t j,
                                              std::ptrdiff_t n, std::ptrdiff_t filled, Sum& sum) {
    if constexpr (fits<T>(C))
      for (; j + C <= n; j += C) add_block<r, C>(A, B, i, j, filled, sum);
    if constexpr (fits<T>(2) && C > 2)
      for (; j + 2 <= n; j += 2) add_block<r, 2>(A, B, i, j, filled, sum);
    for (; j < n; ++j) add_block<r, 1>(A, B, i, j, filled, sum);
  }

  template <int r, int c, class T, class Sum>
  [[gnu::always_inline]] static void add_block(T& A, T& B, std::ptrdiff_t i, std::ptrdiff_t j,
                                               std::ptrdiff_t filled, Sum& sum) {
    decltype(sum.load(0, 0)) s[r][c];
#pragma GCC unroll 4
    for (int k = 0; k < r; ++k)
#pragma GCC unroll 4
      for (int l = 0; l < c; ++l) s[k][l] = sum.load(i + k, j + l);
    for (std::ptrdiff_t p = 0; p < filled; ++p)
#pragma GCC unroll 4
      for (int l = 0; l < c; ++l)
#pragma GCC unroll 4
        for (int k = 0; k < r; ++k) s[k][l] = s[k][l] + A[i + k][p] * B[j + l][p];
#pragma GCC unroll 4
    for (int k = 0; k < r; ++k)
#pragma GCC unroll 4
      for (int l = 0; l < c; ++l) sum.store(i + k, j + l, s[k][l]);
  }
};

}  // namespace stiefel
