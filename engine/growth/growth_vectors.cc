#include "engine/growth/growth_vectors.h"

#include <cmath>
#include <random>

#include "stiefel/linearization.h"
#include "stiefel/stop.h"

namespace stiefel {

using Dense = Eigen::MatrixXd;

GrowthVectors::GrowthVectors(const Scene& scene, const Simulation& start)
    : chart_(scene, blocks_of(start)) {
  const Dense x = blocks_of(start);
  Dense weights(x.rows(), x.cols());
  for (Eigen::Index top = 0, b = 0; top < x.rows(); ++b) {
    const Eigen::Index height = start.fields()[static_cast<std::size_t>(b)].rows;
    const double norm = x.middleRows(top, height).norm();
    weights.middleRows(top, height)
        .setConstant(norm > 0 ? std::sqrt(static_cast<double>(height)) / norm : 1);
    top += height;
  }
  weights_ = weights.reshaped();
}

std::int64_t GrowthVectors::dimension(const Dense& x) const {
  if (chart_.is_body()) return x.cols() * (x.cols() - 1) / 2 * (x.rows() > x.cols() ? 2 : 1);
  if (size() > Linearization::largest_in_coordinates) return 0;
  return orthonormal_range(weights_.asDiagonal() * chart_.tangents_of_units(x) *
                           weights_.cwiseInverse().asDiagonal())
      .cols();
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
    stop_point(static_cast<double>((4 * j + 8 * x.cols()) * size()));
    V.col(j) =
        weights_.cwiseProduct(chart_.tangent(x, V.col(j).reshaped(x.rows(), x.cols())).reshaped());
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
