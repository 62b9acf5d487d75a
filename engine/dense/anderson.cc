#include "engine/dense/anderson.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "stiefel/stop.h"

namespace stiefel {

Anderson::Anderson(Index rows, Index cols, Index depth) {
  depth = std::min({depth, most, rows * cols});
  g_.assign(static_cast<std::size_t>(depth) + 1, Matrix<double>(rows, cols));
  f_ = g_;
  df_.resize(rows * cols, depth);
}

void Anderson::mix(Matrix<double>& x) {
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most, most>;
  using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most, 1>;
  const std::size_t ring = g_.size(), differences = std::min(seen_ - 1, ring - 1);
  const auto columns = static_cast<Index>(differences);
  if (columns < 1) return;
  const auto later = [&](Index i) { return seen_ - static_cast<std::size_t>(columns - i); };
  const auto f = f_[(seen_ - 1) % ring].reshaped();
  Small normal(columns, columns);
  SmallVector scale(columns), c(columns);
  for (Index i = 0; i < columns; ++i) {
    df_.col(i) = f_[later(i) % ring].reshaped() - f_[(later(i) - 1) % ring].reshaped();
    const double norm = df_.col(i).norm();
    scale(i) = norm > 0 ? 1 / norm : 0;
  }
  for (Index i = 0; i < columns; ++i) {
    stop_point();
    c(i) = scale(i) * df_.col(i).dot(f);
    for (Index j = 0; j < columns; ++j)
      normal(i, j) = scale(i) * scale(j) * df_.col(i).dot(df_.col(j));
    normal(i, i) += two_to<double>(8 - bits<double>);
  }
  normal.ldlt().solveInPlace(c);
  for (Index i = 0; i < columns; ++i)
    x -= (scale(i) * c(i)) * (g_[later(i) % ring] - g_[(later(i) - 1) % ring]);
}

void Anderson::operator()(Vector<double>& x, const Vector<double>& f) {
  this->f() = f;
  g() = x + f;
  Matrix<double> next = g();
  keep();
  mix(next);
  x = next;
}

}  // namespace stiefel
