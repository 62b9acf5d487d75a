#include "engine/frame/geodesics/plane_rotations.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "engine/dense/decompositions.h"
#include "engine/frame/geodesics/connect_work.h"
#include "stiefel/stop.h"

namespace stiefel {

using Eigen::Index;
using Eigen::MatrixXd;
using std::numbers::pi;

PlaneRotations::PlaneRotations(const MatrixXd& R) {
  stop_point(5 * connect_work::frame(R.rows(), R.rows()));
  auto [T, vectors] = real_schur(R);
  Z = std::move(vectors);
  std::vector<Index> fixed, flipped;
  for (Index i = 0; i < T.rows();) {
    if (i + 1 < T.rows() && T(i + 1, i) != 0) {
      const double sine = (T(i + 1, i) - T(i, i + 1)) / 2, cosine = (T(i, i) + T(i + 1, i + 1)) / 2;
      planes.push_back({i, i + 1, std::atan2(sine, cosine)});
      i += 2;
    } else {
      (T(i, i) > 0 ? fixed : flipped).push_back(i);
      ++i;
    }
  }
  for (std::size_t i = 0; i + 1 < flipped.size(); i += 2)
    planes.push_back({flipped[i], flipped[i + 1], pi});
  for (std::size_t i = 0; i + 1 < fixed.size(); i += 2)
    planes.push_back({fixed[i], fixed[i + 1], 0.0});
}

MatrixXd PlaneRotations::at(double s) const {
  MatrixXd G = MatrixXd::Identity(Z.rows(), Z.cols());
  for (const auto& [i, j, angle] : planes) {
    G(i, i) = G(j, j) = std::cos(s * angle);
    G(j, i) = std::sin(s * angle);
    G(i, j) = -G(j, i);
  }
  return Z * G * Z.transpose();
}

MatrixXd PlaneRotations::logarithm() const {
  MatrixXd W = MatrixXd::Zero(Z.rows(), Z.cols());
  for (const auto& [i, j, angle] : planes) {
    W(j, i) = angle;
    W(i, j) = -angle;
  }
  return Z * W * Z.transpose();
}

}  // namespace stiefel
