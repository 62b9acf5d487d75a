#include "engine/frames/geodesics/starts.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "engine/linalg/matrix_equations/eigenvectors.h"
#include "engine/frames/geodesics/connect_work.h"
#include "engine/frames/geodesics/plane_rotations.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using std::numbers::pi;

class Starts {
 public:
  Starts(Index n, Index N, int K, std::uint64_t seed) : n_(n), N_(N), K_(K), generator_(seed) {}

  std::vector<Path> all(const MatrixXd& Q_0, const MatrixXd& Q_T, int restarts, bool wide) {
    std::vector<Path> result;
    if (rotations()) {
      PlaneRotations W(completed(Q_0).transpose() * completed(Q_T));
      result.push_back(turned(Q_0, W, Q_T, K_));
      for (auto& plane : W.planes) {
        const double angle = plane.angle;
        plane.angle = angle > 0 ? angle - 2 * pi : angle + 2 * pi;
        result.push_back(turned(Q_0, W, Q_T, K_));
        plane.angle = angle;
      }
    } else {
      result.push_back(direct(Q_0, Q_T, K_));
      if (wide) result.push_back(through(-result[0][static_cast<std::size_t>(K_ / 2)], Q_0, Q_T));
    }
    for (int i = 0; i < restarts; ++i) result.push_back(through(random_frame(Q_0), Q_0, Q_T));
    return result;
  }

 private:
  Path through(const MatrixXd& R, const MatrixXd& Q_0, const MatrixXd& Q_T) {
    Path path = direct(Q_0, R, K_ / 2);
    const Path rest = direct(R, Q_T, K_ - K_ / 2);
    path.insert(path.end(), rest.begin() + 1, rest.end());
    return path;
  }

  bool rotations() const { return n_ + 1 >= N_; }

  Path direct(const MatrixXd& from, const MatrixXd& to, int K) {
    if (!rotations()) return straight(from, to, K);
    return turned(from, PlaneRotations(completed(from).transpose() * completed(to)), to, K);
  }

  static Path turned(const MatrixXd& from, const PlaneRotations& W, const MatrixXd& to, int K) {
    Path path = {from};
    for (int k = 1; k < K; ++k) {
      stop_point(connect_work::turned(static_cast<double>(to.cols())));
      path.push_back(from * W.at(double(k) / K));
    }
    path.push_back(to);
    return path;
  }

  Path straight(const MatrixXd& from, const MatrixXd& to, int K) {
    constexpr double singular = 2.5e-3;  // bound for the smallest eigenvalue of AAᵀ
    MatrixXd bend = MatrixXd::Zero(n_, N_);
    for (;;) {
      Path path = {from};
      double least = 1;
      for (int k = 1; k < K; ++k) {
        stop_point(connect_work::straight(static_cast<double>(n_), static_cast<double>(N_)));
        const double s = double(k) / K;
        const MatrixXd A = (1 - s) * from + s * to + std::sin(pi * s) * bend;
        const MatrixXd square = A * A.transpose();
        const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(square, Eigen::EigenvaluesOnly);
        least = std::min(least, solver.eigenvalues()(0));
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
    if (R.determinant() < 0) R.row(n_) = -R.row(n_);
    return R;
  }

  /// Returns a random frame; for n = N with the determinant of `like`.
  MatrixXd random_frame(const MatrixXd& like) {
    stop_point(connect_work::straight(static_cast<double>(n_), static_cast<double>(N_)));
    MatrixXd R = polar(random());
    if (n_ == N_ && R.determinant() * like.determinant() < 0) R.row(0) = -R.row(0);
    return R;
  }

  MatrixXd random() {
    MatrixXd A(n_, N_);
    for (double& x : A.reshaped()) x = 2 * std::generate_canonical<double, 53>(generator_) - 1;
    return A;
  }

  Index n_, N_;
  int K_;
  std::mt19937_64 generator_;
};

}  // namespace

std::vector<Path> starts(const MatrixXd& Q_0, const MatrixXd& Q_T, int K, int restarts,
                         std::uint64_t seed, bool wide) {
  return Starts(Q_0.rows(), Q_0.cols(), K, seed).all(Q_0, Q_T, restarts, wide);
}

}  // namespace stiefel
