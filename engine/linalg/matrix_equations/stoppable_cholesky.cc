#include "engine/linalg/matrix_equations/stoppable_cholesky.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "stiefel/stop.h"

namespace stiefel {

using Eigen::Index;

namespace {

constexpr double instructions = 0.7;  // of a factorisation, times the cube of its size

double cube(Index size) { return std::pow(static_cast<double>(size), 3); }

}  // namespace

bool factor_positive(Matrix<double>& A) {
  const Index size = A.rows();
  const Index block = size < 32 ? size : std::clamp<Index>(size / 8 / 16 * 16, 8, 128);
  for (Index k = 0; k < size; k += block) {
    const Index now = std::min(block, size - k), rest = size - k - now;
    stop_point(instructions * (cube(now + rest) - cube(rest)));
    auto corner = A.block(k, k, now, now);
    if (Eigen::internal::llt_inplace<double, Eigen::Lower>::unblocked(corner) >= 0) return false;
    if (rest == 0) break;
    auto below = A.block(k + now, k, rest, now);
    corner.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(below);
    A.bottomRightCorner(rest, rest).selfadjointView<Eigen::Lower>().rankUpdate(below, -1.0);
  }
  return true;
}

void divide_by_lower(const Matrix<double>& L, Matrix<double>& B) {
  constexpr Index columns = 32;
  for (Index k = 0; k < B.cols(); k += columns) {
    const Index now = std::min(columns, B.cols() - k);
    stop_point(instructions * static_cast<double>(now * L.size()));
    auto some = B.middleCols(k, now);
    L.triangularView<Eigen::Lower>().solveInPlace(some);
  }
}

}  // namespace stiefel
