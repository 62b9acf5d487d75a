#include "engine/problems/starts.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "engine/linalg/matrix_equations/eigenvectors.h"
#include "engine/linalg/matrix_equations/stoppable_schur.h"
#include "engine/problems/connect_work.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using std::numbers::pi;

/// R = Z exp(W) Zᵀ in plane rotations: each plane rotates two columns of Z by an angle.
struct PlaneRotations {
  struct Plane {
    Index first, second;
    double angle;
  };
  MatrixXd Z;
  std::vector<Plane> planes;

  /// Takes the angles from the real Schur form of R, det R = 1, which is block diagonal.
  explicit PlaneRotations(const MatrixXd& R) {
    stop_point(connect_work::planes(static_cast<double>(R.rows())));
    const Eigen::RealSchur<MatrixXd> schur(R);
    const MatrixXd& T = schur.matrixT();
    Z = schur.matrixU();
    std::vector<Index> fixed, flipped;
    for (Index i = 0; i < T.rows();) {
      if (i + 1 < T.rows() && T(i + 1, i) != 0) {
        const double sine = (T(i + 1, i) - T(i, i + 1)) / 2,
                     cosine = (T(i, i) + T(i + 1, i + 1)) / 2;
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

  /// Returns Z exp(sW) Zᵀ.
  MatrixXd at(double s) const {
    MatrixXd G = MatrixXd::Identity(Z.rows(), Z.cols());
    for (const auto& [i, j, angle] : planes) {
      G(i, i) = G(j, j) = std::cos(s * angle);
      G(j, i) = std::sin(s * angle);
      G(i, j) = -G(j, i);
    }
    return Z * G * Z.transpose();
  }
};

class Starts {
 public:
  Starts(Index n, Index N, int K, std::uint64_t seed) : n_(n), N_(N), K_(K), generator_(seed) {}

  std::vector<Path> all(const MatrixXd& Q_0, const MatrixXd& Q_T, int restarts) {
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
    }
    for (int i = 0; i < restarts; ++i) {
      const MatrixXd R = random_frame(Q_0);
      Path path = direct(Q_0, R, K_ / 2);
      const Path rest = direct(R, Q_T, K_ - K_ / 2);
      path.insert(path.end(), rest.begin() + 1, rest.end());
      result.push_back(path);
    }
    return result;
  }

 private:
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
                         std::uint64_t seed) {
  return Starts(Q_0.rows(), Q_0.cols(), K, seed).all(Q_0, Q_T, restarts);
}

}  // namespace stiefel
