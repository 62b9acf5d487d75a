#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <type_traits>

#include "engine/numbers/parallel.h"
#include "stiefel/stop.h"

namespace stiefel {

/// A rough number of nanoseconds for an operation, a multiplication with its addition, of a product
/// of large matrices.
template <class Scalar>
inline constexpr double operation_nanoseconds = std::is_same_v<Scalar, double>  ? 0.13
                                                : std::is_same_v<Scalar, float> ? 0.07
                                                                                : 1;

/// Number of operations of one piece of work on large matrices between two checks for a stop
/// request. It takes less than 10⁸ instructions with registers of two doubles.
template <class Scalar>
inline constexpr double piece_operations = 3e7 * std::min(1.0, operation_nanoseconds<double> /
                                                                   operation_nanoseconds<Scalar>);

/// The number of columns of the smallest block.
inline constexpr Eigen::Index least_columns = 8;

/// Divides an out = A·B of rows × columns elements, or another computation of so many elements of
/// `of_element` operations on Scalars each, and calls `piece(i, rows, j, columns)` for blocks of
/// it, with a check for a stop request before each. From the size of a product of two matrices of
/// `least_divided_order` the threads of the crew share blocks of about a millisecond, which have
/// all the rows unless `cuts_rows`. On one thread there are blocks of columns from two pieces of
/// `piece_operations`. Smaller work is left to `whole()`. Needs two blocks' columns.
///
/// The bits are those of `whole()`: Eigen's kernels for products and for triangular systems sum
/// every element over the same terms in the same order whatever the number of columns, as long as
/// a block begins at a multiple of 4 columns and is not a vector, and of rows if it begins at a
/// multiple of 48.
template <class Scalar, bool cuts_rows, class Piece, class Whole>
void divide_into_blocks(Eigen::Index rows, Eigen::Index columns, double of_element,
                        const Piece& piece, const Whole& whole) {
  using Eigen::Index;
  constexpr Index least_of_thread = 32, most_of_thread = 64, blocks_of_thread = 2;
  constexpr Index row_unit = 48;
  constexpr double least_operations = 1e6;  // of a block that is wider than `most_of_thread`
  constexpr double divided = 1.0 * least_divided_order * least_divided_order * least_divided_order;
  constexpr double most_operations = 1e6 / operation_nanoseconds<Scalar>;
  const double of_column = of_element * static_cast<double>(rows);
  const double operations = of_column * static_cast<double>(columns);
  const auto worth = [&](double all, double each, Index unit) {
    return std::max(unit, static_cast<Index>(all / each) / unit * unit);
  };
  Crew* crew = columns < 2 * least_of_thread || operations < divided ? nullptr : crew_to_divide();
  const auto threads = crew ? static_cast<Index>(crew->threads_at_hand()) : 1;
  if (threads < 2 && operations <= 2 * piece_operations<Scalar>) return whole();

  Index width = worth(piece_operations<Scalar>, of_column, least_columns), height = rows;
  if (threads > 1) {
    const Index share = columns / (blocks_of_thread * threads) / least_columns * least_columns;
    width = std::clamp(share, least_of_thread, worth(least_operations, of_column, most_of_thread));
    if (cuts_rows)
      height = std::max(2 * row_unit,
                        worth(most_operations, of_element * static_cast<double>(width), row_unit));
    else
      width = std::min(
          width, std::max(2 * least_columns, worth(most_operations, of_column, least_columns)));
  }
  const Index across = std::max<Index>(1, columns / width),
              down = std::max<Index>(1, rows / height);
  const auto one = [&](std::size_t index) {
    const Index at = static_cast<Index>(index), i = at % down * height, j = at / down * width;
    stop_point();
    piece(i, at % down + 1 == down ? rows - i : height, j,
          at / down + 1 == across ? columns - j : width);
  };
  const auto blocks = static_cast<std::size_t>(across * down);
  if (threads > 1) return share_out(*crew, blocks, operations * operation_nanoseconds<Scalar>, one);
  for (std::size_t index = 0; index < blocks; ++index) one(index);
}

/// Calls `whole()` for fewer columns than two blocks have, and divide_into_blocks for more. Steps
/// of small systems make this one comparison, inlined.
template <class Scalar, bool cuts_rows, class Piece, class Whole>
void by_blocks(Eigen::Index rows, Eigen::Index columns, double of_element, const Piece& piece,
               const Whole& whole) {
  if (columns < 2 * least_columns) return whole();
  divide_into_blocks<Scalar, cuts_rows>(rows, columns, of_element, piece, whole);
}

/// Calls `set(A, B, out)` for blocks of A·B and of `out`, by the rules of by_blocks.
template <class Left, class Right, class Out, class Set>
void product_by_blocks(const Left& A, const Right& B, Out& out, const Set& set) {
  using Scalar = typename Left::Scalar;
  constexpr bool cuts_rows = Eigen::internal::has_direct_access<Left>::ret;
  by_blocks<Scalar, cuts_rows>(
      A.rows(), B.cols(), static_cast<double>(A.cols()),
      [&](Eigen::Index i, Eigen::Index rows, Eigen::Index j, Eigen::Index columns) {
        const auto right = B.middleCols(j, columns);
        if (rows == A.rows())
          set(A, right, out.middleCols(j, columns));
        else if constexpr (cuts_rows)
          set(A.middleRows(i, rows), right, out.block(i, j, rows, columns));
      },
      [&] { set(A, B, out); });
}

/// Sets out = A·B. `out` must be another matrix than A and B.
template <class Left, class Right, class Out>
void stoppable_product(const Left& A, const Right& B, Out&& out) {
  out.resize(A.rows(), B.cols());
  product_by_blocks(A, B, out, [](const auto& left, const auto& right, auto&& block) {
    block.noalias() = left * right;
  });
}

/// Sets out = A·B, and announces its operations to `stop_point`: in extended and quadruple
/// precision one product of large matrices takes seconds. `out` must be another matrix than A and
/// B.
template <class Left, class Right, class Out>
void announced_product(const Left& A, const Right& B, Out&& out) {
  stop_point(static_cast<double>(A.size()) * static_cast<double>(B.cols()));
  stoppable_product(A, B, out);
}

/// Sets out ← out + A·B. `out` must be another matrix than A and B.
template <class Left, class Right, class Out>
void add_stoppable_product(const Left& A, const Right& B, Out&& out) {
  product_by_blocks(A, B, out, [](const auto& left, const auto& right, auto&& block) {
    block.noalias() += left * right;
  });
}

/// Sets the elements on and above the diagonal of out = AᵀA. A and `out` must be different
/// matrices. The bits do not depend on the division into blocks of columns.
template <class Matrix>
void stoppable_gram(const Matrix& A, Matrix& out) {
  using Scalar = typename Matrix::Scalar;
  constexpr Eigen::Index width = 48;
  const Eigen::Index N = A.cols();
  const double operations = static_cast<double>(A.size()) * static_cast<double>(N) / 2;
  const auto corner = [&](Eigen::Index j, Eigen::Index columns) {
    auto block = out.block(j, j, columns, columns);
    block.template triangularView<Eigen::Upper>().setZero();
    block.template selfadjointView<Eigen::Upper>().rankUpdate(A.middleCols(j, columns).transpose());
  };
  Crew* crew = N < least_divided_order ? nullptr : crew_to_divide();
  if (crew && crew->threads_at_hand() < 2) crew = nullptr;
  if (!crew && operations <= 2 * piece_operations<Scalar>) return corner(0, N);
  const auto blocks = static_cast<std::size_t>(std::max<Eigen::Index>(1, N / width));
  const auto one = [&](std::size_t k) {  // the largest first
    const Eigen::Index j = static_cast<Eigen::Index>(blocks - 1 - k) * width;
    const Eigen::Index columns = k == 0 ? N - j : width;
    stop_point();
    if (j > 0)
      out.block(0, j, j, columns).noalias() = A.leftCols(j).transpose() * A.middleCols(j, columns);
    corner(j, columns);
  };
  if (crew) return share_out(*crew, blocks, operations * operation_nanoseconds<Scalar>, one);
  for (std::size_t k = 0; k < blocks; ++k) one(k);
}

}  // namespace stiefel
