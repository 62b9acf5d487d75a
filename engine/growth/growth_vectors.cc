#include "engine/growth/growth_vectors.h"

#include <cmath>
#include <random>

#include "engine/dense/decompositions.h"
#include "engine/motion/observed_simulation.h"
#include "stiefel/linearization.h"
#include "stiefel/stop.h"

namespace stiefel {

using Dense = Eigen::MatrixXd;

GrowthVectors::GrowthVectors(const Scene& scene, TangentSpace space, const Simulation& start)
    : space_(std::move(space)) {
  const Dense x = state(start);
  rows_ = x.rows();
  cols_ = x.cols();
  const bool one_block = rows_ == cols_ && !(scene.has_frame() && rows_ > scene.Q().rows());
  const Eigen::Index blocks = one_block || rows_ % 2 != 0 ? 1 : 2, height = rows_ / blocks;
  Dense weights(rows_, cols_);
  for (Eigen::Index b = 0; b < blocks; ++b) {
    const double norm = x.middleRows(b * height, height).norm();
    weights.middleRows(b * height, height)
        .setConstant(norm > 0 ? std::sqrt(static_cast<double>(height)) / norm : 1);
  }
  weights_ = weights.reshaped();
}

std::int64_t GrowthVectors::dimension(const Dense& x) const {
  if (is_body()) return cols_ * (cols_ - 1) / 2 * (rows_ > cols_ ? 2 : 1);
  if (size() > Linearization::largest_in_coordinates) return 0;
  Dense all(size(), size());
  for (Eigen::Index k = 0; k < size(); ++k) {
    stop_point(static_cast<double>(rows_ * size()));
    Dense G = Dense::Zero(rows_, cols_);
    G(k) = 1 / weights_(k);
    all.col(k) = weights_.cwiseProduct(tangent(x, G).reshaped());
  }
  return orthonormal_range(std::move(all)).cols();
}

Dense GrowthVectors::state(const Simulation& motion) const {
  // A scene without members has no other simulation.
  const Dense& point = dynamic_cast<const ObservedSimulation&>(motion).point();
  if (point.cols() > 1) return point;
  // A body in three dimensions: (q; m) or m.
  if (point.rows() == 3) return motion.get("M");
  Dense x(6, 3);
  x << motion.get("Q"), motion.get("M");
  return x;
}

Dense GrowthVectors::tangent(const Dense& x, const Dense& G) const {
  if (!is_body()) return space_.tangent(x, G);
  Dense out(rows_, cols_);
  out.bottomRows(cols_) = skew_part(G.bottomRows(cols_));
  if (rows_ == cols_) return out;
  const auto Q = x.topRows(cols_), dQ = G.topRows(cols_);
  out.topRows(cols_) = Q * skew_part(Q.transpose() * dQ);
  return out;
}

Dense GrowthVectors::random(const Dense& x, Eigen::Index k, std::uint64_t seed) const {
  std::mt19937_64 bits(seed);
  Dense V(size(), k);
  for (Eigen::Index j = 0; j < k; ++j) {
    stop_point();
    for (double& v : V.col(j)) v = static_cast<double>(bits() >> 11) * 0x1p-52 - 1;  // in (−1, 1)
  }
  V = weights_.cwiseInverse().asDiagonal() * V;
  orthonormalise(x, V);
  return V;
}

Dense GrowthVectors::orthonormalise(const Dense& x, Dense& V) const {
  const Eigen::Index k = V.cols();
  Dense R = Dense::Zero(k, k);
  for (Eigen::Index j = 0; j < k; ++j) {
    stop_point(static_cast<double>((4 * j + 8 * cols_) * size()));
    V.col(j) = weights_.cwiseProduct(tangent(x, V.col(j).reshaped(rows_, cols_)).reshaped());
    for (int pass = 0; pass < 2; ++pass)
      for (Eigen::Index i = 0; i < j; ++i) {
        const double part = V.col(i).dot(V.col(j));
        V.col(j) -= part * V.col(i);
        R(i, j) += part;
      }
    R(j, j) = V.col(j).norm();
    V.col(j) /= R(j, j);
  }
  V = weights_.cwiseInverse().asDiagonal() * V;
  return R;
}

}  // namespace stiefel
