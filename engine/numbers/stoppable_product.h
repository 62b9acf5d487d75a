#pragma once

#include <Eigen/LU>
#include <algorithm>

#include "stiefel/stop.h"

namespace stiefel {

/// Number of operations of one piece of work on large matrices between two checks for a stop
/// request. It takes less than 10⁸ instructions with registers of two doubles.
inline constexpr double piece_operations = 3e7;

/// Divides work on `all` columns, each of `of_column` operations, into pieces of a multiple of 8
/// columns, and calls `piece(j, columns)` for each, with a check for a stop request before it.
/// Calls `whole()` where the work does not fill two pieces. The bits are those of `whole()`:
/// Eigen's kernels for products and for triangular systems sum every element over the same blocks
/// whatever the number of columns, as long as a piece begins at a multiple of 4 and is not a
/// vector.
template <class Piece, class Whole>
void by_columns(Eigen::Index all, double of_column, const Piece& piece, const Whole& whole) {
  constexpr Eigen::Index least = 8;
  if (of_column * static_cast<double>(all) <= 2 * piece_operations || all < 2 * least)
    return whole();
  const auto paid = static_cast<Eigen::Index>(piece_operations / of_column);
  const Eigen::Index size = std::max(least, paid / least * least);
  for (Eigen::Index j = 0, columns = 0; j < all; j += columns) {
    const Eigen::Index left = all - j;
    columns = left < 2 * size ? left : size;
    stop_point();
    piece(j, columns);
  }
}

/// Sets out = A·B. `out` must be another matrix than A and B.
template <class Left, class Right, class Out>
void stoppable_product(const Left& A, const Right& B, Out&& out) {
  by_columns(
      B.cols(), static_cast<double>(A.rows()) * static_cast<double>(A.cols()),
      [&](Eigen::Index j, Eigen::Index columns) {
        if (j == 0) out.resize(A.rows(), B.cols());
        out.middleCols(j, columns).noalias() = A * B.middleCols(j, columns);
      },
      [&] { out.noalias() = A * B; });
}

/// Sets out = A·B, and announces the operations of every piece, or of the whole product, to
/// `stop_point`: in extended and quadruple precision one product of large matrices takes seconds.
/// `out` must be another matrix than A and B, and of the size of A·B.
template <class Left, class Right, class Out>
void announced_product(const Left& A, const Right& B, Out&& out) {
  const auto of_column = static_cast<double>(A.size());
  by_columns(
      B.cols(), of_column,
      [&](Eigen::Index j, Eigen::Index columns) {
        stop_point(of_column * static_cast<double>(columns));
        out.middleCols(j, columns).noalias() = A * B.middleCols(j, columns);
      },
      [&] {
        stop_point(of_column * static_cast<double>(B.cols()));
        out.noalias() = A * B;
      });
}

/// Sets out ← out + A·B. `out` must be another matrix than A and B.
template <class Left, class Right, class Out>
void add_stoppable_product(const Left& A, const Right& B, Out&& out) {
  by_columns(
      B.cols(), static_cast<double>(A.rows()) * static_cast<double>(A.cols()),
      [&](Eigen::Index j, Eigen::Index columns) {
        out.middleCols(j, columns).noalias() += A * B.middleCols(j, columns);
      },
      [&] { out.noalias() += A * B; });
}

/// Sets X = A⁻¹B from the LU factors of A. X must be another matrix than B.
template <class Matrix, class Right, class Out>
void stoppable_solve(const Eigen::PartialPivLU<Matrix>& A, const Right& B, Out& X) {
  by_columns(
      B.cols(), static_cast<double>(A.rows()) * static_cast<double>(A.cols()),
      [&](Eigen::Index j, Eigen::Index columns) {
        if (j == 0) X.resize(A.rows(), B.cols());
        X.middleCols(j, columns) = A.solve(B.middleCols(j, columns));
      },
      [&] { X = A.solve(B); });
}

}  // namespace stiefel
