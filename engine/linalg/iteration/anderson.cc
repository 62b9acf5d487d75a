#include "engine/linalg/iteration/anderson.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "stiefel/stop.h"

namespace stiefel {

using Eigen::Index;

Anderson::Anderson(Index size, Index depth)
    : depth_(std::min({depth, most, size})), g_(size), f_(size), dg_(size, depth_), df_(dg_) {}

void Anderson::add(const Numbers& g, const Numbers& f) {
  if (seen_ > 0) {
    const Index column = (seen_ - 1) % depth_;
    dg_.col(column) = g - g_;
    df_.col(column) = f - f_;
  }
  g_ = g;
  f_ = f;
  ++seen_;
}

void Anderson::mix(Eigen::Map<Vector<double>> x) const {
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most, most>;
  using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most, 1>;
  const Index columns = std::min(seen_ - 1, depth_);
  if (columns < 1) return;
  Small normal(columns, columns);
  SmallVector scale(columns), c(columns);
  for (Index i = 0; i < columns; ++i) {
    const double norm = df_.col(i).norm();
    scale(i) = norm > 0 ? 1 / norm : 0;
  }
  for (Index i = 0; i < columns; ++i) {
    stop_point();
    c(i) = scale(i) * df_.col(i).dot(f_);
    for (Index j = 0; j < columns; ++j)
      normal(i, j) = scale(i) * scale(j) * df_.col(i).dot(df_.col(j));
    normal(i, i) += two_to<double>(8 - bits<double>);
  }
  normal.ldlt().solveInPlace(c);
  for (Index i = 0; i < columns; ++i) x -= (scale(i) * c(i)) * dg_.col(i);
}

void Anderson::operator()(Vector<double>& x, const Vector<double>& f) {
  x += f;
  add({x.data(), x.size()}, {f.data(), f.size()});
  mix({x.data(), x.size()});
}

}  // namespace stiefel
