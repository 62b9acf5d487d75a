#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "engine/dense/decompositions.h"
#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/path.h"
#include "stiefel/stop.h"

namespace stiefel {

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

namespace {

class Starts {
 public:
  Starts(Index n, Index N, const VectorXd& times, std::uint64_t seed)
      : n_(n), N_(N), times_(times.begin(), times.end()), generator_(seed) {}

  std::vector<Path> all(const MatrixXd& Q_0, const MatrixXd& Q_T, int restarts, bool wide) {
    std::vector<Path> result;
    if (rotations()) {
      PlaneRotations W(completed(Q_0).transpose() * completed(Q_T));
      result.push_back(turned(Q_0, W, Q_T, times_));
      for (auto& plane : W.planes) {
        const double angle = plane.angle;
        if (restarts == 0 && std::abs(angle) < pi / 2) continue;
        plane.angle = angle > 0 ? angle - 2 * pi : angle + 2 * pi;
        result.push_back(turned(Q_0, W, Q_T, times_));
        plane.angle = angle;
      }
    } else {
      result.push_back(direct(Q_0, Q_T, times_));
      if (wide) result.push_back(through(-result[0][times_.size() / 2], Q_0, Q_T));
    }
    for (int i = 0; i < restarts; ++i) result.push_back(through(random_frame(Q_0), Q_0, Q_T));
    return result;
  }

 private:
  Path through(const MatrixXd& R, const MatrixXd& Q_0, const MatrixXd& Q_T) {
    std::vector<double> first, second;
    for (const double t : times_) (t < 0.5 ? first : second).push_back(t < 0.5 ? 2 * t : 2 * t - 1);
    first.push_back(1);
    if (second.front() > 0) second.insert(second.begin(), 0);
    Path path = direct(Q_0, R, first);
    const Path rest = direct(R, Q_T, second);
    const bool middle = std::ranges::find(times_, 0.5) != times_.end();
    if (!middle) path.pop_back();
    path.insert(path.end(), rest.begin() + 1, rest.end());
    return path;
  }

  bool rotations() const { return n_ + 1 >= N_; }

  /// The times of a path run from 0 to 1.
  using Times = std::vector<double>;

  Path direct(const MatrixXd& from, const MatrixXd& to, const Times& times) {
    if (!rotations()) return straight(from, to, times);
    return turned(from, PlaneRotations(completed(from).transpose() * completed(to)), to, times);
  }

  static Path turned(const MatrixXd& from, const PlaneRotations& W, const MatrixXd& to,
                     const Times& times) {
    Path path = {from};
    for (std::size_t k = 1; k + 1 < times.size(); ++k) {
      stop_point(connect_work::frame(to.cols(), to.cols()));
      path.push_back(from * W.at(times[k]));
    }
    path.push_back(to);
    return path;
  }

  Path straight(const MatrixXd& from, const MatrixXd& to, const Times& times) {
    constexpr double singular = 2.5e-3;  // bound for the smallest eigenvalue of AAᵀ
    MatrixXd bend = MatrixXd::Zero(n_, N_);
    for (;;) {
      Path path = {from};
      double least = 1;
      for (std::size_t k = 1; k + 1 < times.size(); ++k) {
        stop_point(2 * connect_work::frame(n_, N_));
        const double s = times[k];
        const MatrixXd A = (1 - s) * from + s * to + std::sin(pi * s) * bend;
        const MatrixXd square = A * A.transpose();
        least = std::min(least, symmetric_eigenvalues(square)(0));
        path.push_back(polar(A));
      }
      path.push_back(to);
      if (least > singular) return path;
      bend += 0.2 * random();
    }
  }

  /// Returns Q; for n = N − 1 completed by one row so that the determinant is 1.
  MatrixXd completed(const MatrixXd& Q) const {
    if (n_ == N_) return Q;
    MatrixXd R(N_, N_);
    R << Q, complement(Q);
    if (determinant(R) < 0) R.row(n_) = -R.row(n_);
    return R;
  }

  /// Returns a random frame; for n = N with the determinant of `like`.
  MatrixXd random_frame(const MatrixXd& like) {
    stop_point(2 * connect_work::frame(n_, N_));
    MatrixXd R = polar(random());
    if (n_ == N_ && determinant(R) * determinant(like) < 0) R.row(0) = -R.row(0);
    return R;
  }

  MatrixXd random() {
    MatrixXd A(n_, N_);
    for (double& x : A.reshaped()) x = 2 * std::generate_canonical<double, 53>(generator_) - 1;
    return A;
  }

  Index n_, N_;
  Times times_;
  std::mt19937_64 generator_;
};

}  // namespace

std::vector<Path> starts(const MatrixXd& Q_0, const MatrixXd& Q_T, const VectorXd& times,
                         int restarts, std::uint64_t seed, bool wide) {
  return Starts(Q_0.rows(), Q_0.cols(), times, seed).all(Q_0, Q_T, restarts, wide);
}

}  // namespace stiefel
