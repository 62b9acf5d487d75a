#include "tests/extremes/side_by_side.h"

#include "tests/extremes/bodies.h"

namespace stiefel::extremes {

SideBySide::SideBySide(std::vector<SceneDescription> small, int copies)
    : kinds_(small.size()), copies_(copies), large_(small.front()) {
  const auto K = static_cast<Eigen::Index>(large_.inertia.size());
  T_ = Matrix<long double>::Zero(K * copies, K * copies);
  for (Eigen::Index a = 0; a < K; ++a) {
    Matrix<long double> R =
        random_frame(copies, copies, static_cast<unsigned>(10 + a)).cast<long double>();
    const auto I = Matrix<long double>::Identity(copies, copies);
    for (int k = 0; k < 2; ++k) R = ((3 * I - R * R.transpose()) * R / 2).eval();
    for (Eigen::Index i = 0; i < copies; ++i)
      for (Eigen::Index j = 0; j < copies; ++j) T_(i * K + a, j * K + a) = R(i, j);
  }
  large_.inertia.clear();
  for (int k = 0; k < copies; ++k)
    large_.inertia.insert(large_.inertia.end(), small.front().inertia.begin(),
                          small.front().inertia.end());
  std::vector<MotionState> start;
  const bool body = large_.initial.contains("M");
  for (const SceneDescription& d : small)
    start.push_back({d.initial.at("Q").values.cast<long double>(),
                     d.initial.at(body ? "M" : "S").values.cast<long double>()});
  const MotionState whole = assembled(start);
  large_.initial["Q"] = RowMatrix(whole.attitude.cast<double>());
  large_.initial[body ? "M" : "S"] = RowMatrix(whole.momentum.cast<double>());
}

MotionState SideBySide::assembled(const std::vector<MotionState>& states) const {
  std::vector<Matrix<long double>> Q, M;
  for (const MotionState& state : states) {
    Q.push_back(state.attitude);
    M.push_back(state.momentum);
  }
  MotionState whole{beside(Q) * T_, beside(M) * T_};
  if (large_.initial.contains("M")) whole.momentum = (T_.transpose() * whole.momentum).eval();
  return whole;
}

Matrix<long double> SideBySide::beside(const std::vector<Matrix<long double>>& blocks) const {
  const Eigen::Index n = blocks.front().rows(), N = blocks.front().cols();
  Matrix<long double> all = Matrix<long double>::Zero(copies_ * n, copies_ * N);
  for (int k = 0; k < copies_; ++k)
    all.block(k * n, k * N, n, N) = blocks[static_cast<std::size_t>(k) % kinds_];
  return all;
}

}  // namespace stiefel::extremes
