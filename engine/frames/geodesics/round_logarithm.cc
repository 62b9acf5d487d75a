#include "engine/frames/geodesics/round_logarithm.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/frames/geodesics/anderson.h"
#include "engine/frames/geodesics/connect_work.h"
#include "engine/linalg/lie/exponential.h"
#include "engine/linalg/lie/orthogonal.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

template <int n>
MatrixXd gram_of(const MatrixXd& A, const MatrixXd& B) {
  using Column = Eigen::Map<const Eigen::Matrix<double, n, 1>>;
  constexpr Index chunk = 256;  // sums of chunks keep the rounding of a long sum small
  Eigen::Matrix<double, n, n> sum = Eigen::Matrix<double, n, n>::Zero();
  for (Index from = 0; from < A.cols(); from += chunk) {
    Eigen::Matrix<double, n, n> part = Eigen::Matrix<double, n, n>::Zero();
    for (Index j = from; j < std::min(A.cols(), from + chunk); ++j)
      part.noalias() += Column(A.data() + n * j) * Column(B.data() + n * j).transpose();
    sum += part;
  }
  return sum;
}

template <int n>
void add_product_of(const MatrixXd& C, const MatrixXd& A, MatrixXd& out) {
  const Eigen::Matrix<double, n, n> fixed = C;
  for (Index j = 0; j < A.cols(); ++j)
    Eigen::Map<Eigen::Matrix<double, n, 1>>(out.data() + n * j).noalias() +=
        fixed * Eigen::Map<const Eigen::Matrix<double, n, 1>>(A.data() + n * j);
}

bool is_tall(const MatrixXd& A) { return A.cols() > 1000; }

/// Return ABᵀ, and add CA to `out`, for n × N blocks; faster than Eigen's kernels where n is small
/// and N is large.
MatrixXd gram(const MatrixXd& A, const MatrixXd& B) {
  if (is_tall(A)) switch (A.rows()) {
      case 2:
        return gram_of<2>(A, B);
      case 3:
        return gram_of<3>(A, B);
      case 4:
        return gram_of<4>(A, B);
      case 5:
        return gram_of<5>(A, B);
      case 6:
        return gram_of<6>(A, B);
    }
  return A * B.transpose();
}
void add_product(const MatrixXd& C, const MatrixXd& A, MatrixXd& out) {
  if (is_tall(A)) switch (A.rows()) {
      case 2:
        return add_product_of<2>(C, A, out);
      case 3:
        return add_product_of<3>(C, A, out);
      case 4:
        return add_product_of<4>(C, A, out);
      case 5:
        return add_product_of<5>(C, A, out);
      case 6:
        return add_product_of<6>(C, A, out);
    }
  out.noalias() += C * A;
}

/// The span of two frames with the orthonormal rows [Q_0; K]; a matrix X of n + p rows stands for
/// the n × N block Xᵀ[Q_0; K].
class Span {
 public:
  Span(const MatrixXd& Q_0, const MatrixXd& Q_T)
      : Q_0_(Q_0), n_(Q_0.rows()), p_(std::min(n_, Q_0.cols() - n_)) {
    const double n = static_cast<double>(n_), N = static_cast<double>(Q_0.cols());
    stop_point(connect_work::span(n, N));
    const MatrixXd C = gram(Q_T, Q_0);
    K_ = Q_T;
    add_product(-C, Q_0, K_);
    target_.resize(n_ + p_, n_);
    target_.topRows(n_) = C.transpose();
    if (p_ == n_ && orthonormalised()) return;
    MatrixXd both(Q_0.cols(), 2 * n_);
    both << Q_0.transpose(), (Q_T - C * Q_0).transpose();
    K_ = orthonormal_columns(both, n_ + p_).rightCols(p_).transpose();
    to_K_ = MatrixXd::Identity(p_, p_);
    target_.bottomRows(p_).noalias() = K_ * Q_T.transpose();
  }

  /// Returns the X of Q_T.
  const MatrixXd& target() const { return target_; }

  MatrixXd lifted(const MatrixXd& X) const {
    const MatrixXd of_K = X.bottomRows(p_).transpose() * to_K_;
    MatrixXd out = MatrixXd::Zero(n_, Q_0_.cols());
    add_product(X.topRows(n_).transpose(), Q_0_, out);
    if (p_ == n_)
      add_product(of_K, K_, out);
    else
      out.noalias() += of_K * K_;
    return out;
  }

 private:
  /// Finds the matrix that makes the rows of Q_T − CQ_0 orthonormal, by the Cholesky factors of
  /// their products; the product of the transposed factors is the lower part of the target. Short
  /// or almost dependent rows take a second pass, which first removes what rounding left of Q_0 in
  /// them. Returns false where they are nearly dependent.
  bool orthonormalised() {
    constexpr double good = 0.05, least = 1e-9;  // squares of ratios of singular values
    MatrixXd whole = MatrixXd::Identity(n_, n_);
    to_K_ = whole;
    for (int pass = 0; pass < 2; ++pass) {
      if (pass > 0) {
        K_ = (to_K_ * K_).eval();
        to_K_.setIdentity();
        add_product(-gram(K_, Q_0_), Q_0_, K_);
      }
      const Eigen::LLT<MatrixXd> llt(gram(K_, K_));
      if (llt.info() != Eigen::Success) return false;
      const MatrixXd L = llt.matrixL();
      const VectorXd squares = L.diagonal().cwiseAbs2();
      const double shortest = squares.minCoeff(), ratio = shortest / squares.maxCoeff();
      if (!(ratio > least)) return false;
      to_K_ = L.triangularView<Eigen::Lower>().solve(MatrixXd::Identity(n_, n_));
      whole = (whole * L).eval();
      if (ratio > good && shortest > good) break;
    }
    target_.bottomRows(n_) = whole.transpose();
    return true;
  }

  const MatrixXd& Q_0_;
  Index n_, p_;
  MatrixXd K_, to_K_, target_;  ///< the orthonormal rows are to_K_ · K_
};

/// The iteration for the frames I and T in R^{n+p}, T with n orthonormal columns.
class Shooting {
 public:
  explicit Shooting(const MatrixXd& T)
      : n_(T.cols()),
        p_(T.rows() - n_),
        T_(T),
        V_(n_ + p_, n_),
        W_(n_ + p_, n_ + p_),
        turn_(W_),
        back_(n_, n_),
        quarter_back_(n_, n_),
        exp_W_(n_ + p_),
        exp_A_(n_) {
    Y_.fill(MatrixXd::Identity(n_ + p_, n_));
  }

  /// Iterates from the direction of the chord. Returns whether the miss became rounding.
  bool converge() {
    constexpr int most = 60;
    constexpr double rounding = 4e-15, nearly = 2e-13;
    MatrixXd chord = T_ - Y_[0], D = chord;
    project(Y_[0], D);
    if (!(D.norm() > 0)) return false;
    D *= chord.norm() / D.norm();
    VectorXd x = packed(D);
    Anderson accelerate(x.size(), 10);
    VectorXd best;
    double least = std::numeric_limits<double>::infinity();
    int idle = 0;
    for (int k = 0; k < most && idle < 3; ++k) {
      stop_point(connect_work::shot(static_cast<double>(n_), static_cast<double>(p_)));
      unpack(x);
      go();
      D = Y_[4] - T_;
      const double miss = D.cwiseAbs().maxCoeff();
      if (!std::isfinite(miss)) return false;
      idle = least < nearly && miss > least / 2 ? idle + 1 : 0;
      if (miss < least) least = miss, best = x;
      if (miss <= rounding) break;
      for (std::size_t node = 5; node-- > 0;) project(Y_[node], D);
      accelerate(x, -packed(D));
    }
    if (!(least <= nearly)) return false;
    unpack(best);
    go();
    return true;
  }

  /// Return the velocity at t = 0, and the frame at t = 1.
  const MatrixXd& V() const { return V_; }
  const MatrixXd& end() const { return Y_[4]; }

 private:
  /// Computes the frames at t = 1/4, 1/2, 3/4 and 1.
  void go() {
    const auto A = V_.topRows(n_), B = V_.bottomRows(p_);
    W_.setZero();
    W_.topLeftCorner(n_, n_) = A / 2;
    W_.bottomLeftCorner(p_, n_) = B / 4;
    W_.topRightCorner(n_, p_) = -B.transpose() / 4;
    quarter_back_ = -A / 4;
    exp_W_(W_, turn_);
    exp_A_(quarter_back_, back_);
    for (std::size_t k = 0; k < 4; ++k) {
      product_ = Y_[k];
      product_.noalias() += turn_ * Y_[k];
      Y_[k + 1] = product_;
      Y_[k + 1].noalias() += product_ * back_;
    }
  }

  /// Removes from D what is not tangent at Y.
  void project(const MatrixXd& Y, MatrixXd& D) {
    S_.noalias() = Y.transpose() * D;
    back_ = (S_ + S_.transpose()) / 2;
    D.noalias() -= Y * back_;
  }

  VectorXd packed(const MatrixXd& D) const {
    VectorXd x(n_ * (n_ - 1) / 2 + p_ * n_);
    Index at = 0;
    for (Index j = 0; j < n_; ++j)
      for (Index i = 0; i < j; ++i) x(at++) = (D(i, j) - D(j, i)) / std::sqrt(2.0);
    x.tail(p_ * n_) = D.bottomRows(p_).reshaped();
    return x;
  }
  void unpack(const VectorXd& x) {
    V_.setZero();
    Index at = 0;
    for (Index j = 0; j < n_; ++j)
      for (Index i = 0; i < j; ++i) {
        V_(i, j) = x(at++) / std::sqrt(2.0);
        V_(j, i) = -V_(i, j);
      }
    V_.bottomRows(p_).reshaped() = x.tail(p_ * n_);
  }

  Index n_, p_;
  MatrixXd T_, V_, W_, turn_, back_, quarter_back_, product_, S_;
  std::array<MatrixXd, 5> Y_;
  SkewExponential<double> exp_W_, exp_A_;
};

}  // namespace

std::optional<RoundGeodesic> round_logarithm(const MatrixXd& Q_0, const MatrixXd& Q_T) {
  const Span span(Q_0, Q_T);
  Shooting shooting(span.target());
  if (!shooting.converge()) return {};
  stop_point(connect_work::span(static_cast<double>(Q_0.rows()), static_cast<double>(Q_0.cols())));
  MatrixXd V = span.lifted(shooting.V());
  const double residual = (shooting.end() - span.target()).colwise().norm().maxCoeff();
  return RoundGeodesic{std::move(V), residual};
}

}  // namespace stiefel
