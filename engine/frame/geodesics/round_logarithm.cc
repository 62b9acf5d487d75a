#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "engine/dense/anderson.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/newton_krylov.h"
#include "engine/dense/orthogonal.h"
#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/geodesic_search.h"
#include "engine/numbers/small_product.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

/// Matrices whose columns are padded with zeros to a multiple of 8 numbers, which is what
/// `small_product` takes.
Index padded(Index rows) { return (rows + 7) / 8 * 8; }
MatrixXd padded(const MatrixXd& A) {
  MatrixXd out = MatrixXd::Zero(padded(A.rows()), A.cols());
  out.topRows(A.rows()) = A;
  return out;
}

/// Computes exp(Θ) − I for a padded skew matrix Θ, m × m, by its Taylor polynomial of degree 9, 12
/// or 16 in the fewest products (Paterson and Stockmeyer), with doublings where Θ is large. The
/// error is below rounding; |θ| ≤ (‖Θ²‖_F / √2)^{1/2} for every eigenvalue iθ. Of eigenvalues above
/// 10⁶, which leave no digits, it makes NaN.
class SmallExponential {
 public:
  explicit SmallExponential(Index m)
      : m_(m), powers_{MatrixXd::Zero(padded(m), m), {}, {}, {}}, product_(powers_[0]) {
    std::ranges::fill(powers_, product_);
  }

  void operator()(const MatrixXd& theta, MatrixXd& D) {
    powers_[0] = theta;
    times(theta, theta, powers_[1]);
    const double largest = std::sqrt(powers_[1].norm() / std::numbers::sqrt2);
    if (!(largest < 1e6)) {
      D = MatrixXd::Constant(theta.rows(), m_, std::numeric_limits<double>::quiet_NaN());
      return;
    }
    const int doublings = largest > 0.9 ? static_cast<int>(std::ceil(std::log2(largest / 0.9))) : 0;
    const double scale = std::exp2(-doublings), size = largest * scale;
    if (doublings > 0) {
      powers_[0] *= scale;
      powers_[1] *= scale * scale;
    }
    const int degree = size <= 0.11 ? 9 : size <= 0.33 ? 12 : 16, s = degree == 9 ? 3 : 4;
    times(powers_[1], powers_[0], powers_[2]);
    if (s == 4) times(powers_[1], powers_[1], powers_[3]);
    D = coefficient(degree) * powers_[at(s)];
    for (int block = degree - s; block >= 0; block -= s) {
      for (int k = 1; k < s; ++k) D += coefficient(block + k) * powers_[at(k)];
      if (block == 0) break;
      for (Index i = 0; i < m_; ++i) D(i, i) += coefficient(block);
      times(powers_[at(s)], D, product_);
      D.swap(product_);
    }
    for (int k = 0; k < doublings; ++k) {
      times(D, D, product_);
      D = 2 * D + product_;
    }
  }

 private:
  static std::size_t at(int power) { return static_cast<std::size_t>(power - 1); }
  /// Returns 1/k!.
  static double coefficient(int k) {
    static constexpr auto all = [] {
      std::array<double, 17> factorials{1};
      for (std::size_t i = 1; i < factorials.size(); ++i)
        factorials[i] = factorials[i - 1] * static_cast<double>(i);
      for (double& factorial : factorials) factorial = 1 / factorial;
      return factorials;
    }();
    return all[static_cast<std::size_t>(k)];
  }
  void times(const MatrixXd& A, const MatrixXd& B, MatrixXd& out) const {
    multiply_(A.rows(), m_, m_, A.data(), A.rows(), B.data(), B.rows(), out.data(), out.rows());
  }

  Index m_;
  std::array<MatrixXd, 4> powers_;
  MatrixXd product_;
  SmallProduct multiply_ = small_product();
};

/// The iteration for the frames I and T in R^{n+p}, T with n orthonormal columns. Velocities are
/// packed into vectors x of their degrees of freedom, with ‖x‖ the Euclidean norm.
class RoundShooting {
 public:
  RoundShooting(const MatrixXd& T, double beta)
      : n_(T.cols()),
        p_(T.rows() - n_),
        beta_(beta),
        T_(padded(T)),
        V_(MatrixXd::Zero(T_.rows(), n_)),
        W_(MatrixXd::Zero(T_.rows(), n_ + p_)),
        turn_(W_),
        back_(MatrixXd::Zero(padded(n_), n_)),
        quarter_back_(back_),
        S_(back_),
        product_(V_),
        transposed_(MatrixXd::Zero(padded(n_), n_ + p_)),
        exp_W_(n_ + p_),
        exp_A_(n_) {
    Y_.fill(MatrixXd::Identity(T_.rows(), n_));
  }

  void set_target(const MatrixXd& T) { T_ = padded(T); }

  /// Returns the direction of the chord with its length; 0 where it has none.
  VectorXd chord() {
    MatrixXd D = T_ - Y_[0];
    const double length = D.norm();
    project(Y_[0], D);
    if (D.norm() > 0) D *= length / D.norm();
    return packed(D);
  }

  /// Iterates from x. Returns whether the miss became rounding; x is then the solution.
  bool converge(VectorXd& x) {
    constexpr int most = 60;
    Anderson accelerate(x.size(), 1, 10);
    VectorXd best;
    double least = std::numeric_limits<double>::infinity();
    int idle = 0;
    for (int k = 0; k < most && idle < 3; ++k) {
      const double missed = shoot(x);
      if (!std::isfinite(missed)) return false;
      idle = least < nearly && missed > least / 2 ? idle + 1 : 0;
      if (missed < least) least = missed, best = x;
      if (missed <= rounding) break;
      accelerate(x, -packed(carried_back()));
    }
    if (!(least <= nearly)) return false;
    x = best;
    return true;
  }

  /// Solves from x by Newton's method, and where x is too far from a solution for that, minimises
  /// the miss by the method of Levenberg and Marquardt, with a Jacobian by differences. Returns as
  /// `converge` does.
  bool minimise(VectorXd& x) {
    constexpr int most = 60;
    constexpr Index most_degrees = 600;
    constexpr double change = 0x1p-26;
    const Index d = x.size();
    MatrixXd z = x;
    const bool solved = newton_.solve(z, [&](const MatrixXd& at, MatrixXd& next) {
      shoot(at);
      next = at - packed(carried_back());
    });
    if (solved && shoot(z) <= nearly) {
      x = z;
      return true;
    }
    if (const bool there = shoot(x) <= nearly; there || d > most_degrees) return there;
    MatrixXd J(T_.size(), d), normal;
    VectorXd miss = (Y_[4] - T_).reshaped();
    double damping = 1e-3;
    for (int k = 0; k < most; ++k) {
      if (miss.cwiseAbs().maxCoeff() <= rounding) return true;
      for (Index i = 0; i < d; ++i) {
        VectorXd moved = x;
        moved(i) += change;
        shoot(moved);
        J.col(i) = ((Y_[4] - T_).reshaped() - miss) / change;
      }
      const VectorXd slope = J.transpose() * miss;
      normal.noalias() = J.transpose() * J;
      if (!(slope.norm() > 1e-9 * miss.norm())) return false;  // a minimum that is no solution
      for (bool better = false; !better; damping *= better ? 0.1 : 4) {
        if (damping > 1e8) return miss.cwiseAbs().maxCoeff() <= nearly;
        MatrixXd damped = normal;
        damped.diagonal().array() += damping;
        VectorXd step = slope;
        factor_positive(damped);
        solve_positive(damped, step);
        const VectorXd next = x - step;
        if (!std::isfinite(shoot(next))) continue;
        const VectorXd there = (Y_[4] - T_).reshaped();
        better = there.norm() < miss.norm();
        if (better) x = next, miss = there;
      }
    }
    return false;
  }

  /// Returns the degrees of freedom of a velocity, of n + p rows or padded.
  VectorXd packed(const MatrixXd& D) const {
    VectorXd x(n_ * (n_ - 1) / 2 + p_ * n_);
    Index at = 0;
    for (Index j = 0; j < n_; ++j)
      for (Index i = 0; i < j; ++i) x(at++) = (D(i, j) - D(j, i)) / std::sqrt(2.0);
    x.tail(p_ * n_) = D.middleRows(n_, p_).reshaped();
    return x;
  }

  /// Shoots with x. Returns the largest miss of a number.
  double shoot(const VectorXd& x) {
    stop_point(60000 + 30 * static_cast<double>((n_ + p_) * (n_ + p_) * (n_ + p_)));
    unpack(x);
    go();
    return Y_[4].allFinite() ? (Y_[4] - T_).cwiseAbs().maxCoeff()
                             : std::numeric_limits<double>::infinity();
  }

  /// Return the velocity at t = 0, and the frame at t = 1, of the last shot.
  MatrixXd V() const { return V_.topRows(n_ + p_); }
  MatrixXd frame(std::size_t quarters) const { return Y_[quarters].topRows(n_ + p_); }
  double length() const {
    return std::sqrt(beta_ * V_.topRows(n_).squaredNorm() + V_.middleRows(n_, p_).squaredNorm());
  }

 private:
  static constexpr double rounding = 4e-15, nearly = 2e-13;

  /// Computes the frames at t = 1/4, 1/2, 3/4 and 1.
  void go() {
    const auto A = V_.topRows(n_), B = V_.middleRows(n_, p_);
    W_.topLeftCorner(n_, n_) = (beta_ / 2) * A;
    W_.block(n_, 0, p_, n_) = B / 4;
    W_.topRightCorner(n_, p_) = -B.transpose() / 4;
    exp_W_(W_, turn_);
    const bool turns_back = beta_ != 0.5;
    if (turns_back) {
      quarter_back_.topRows(n_) = ((1 - 2 * beta_) / 4) * A;
      exp_A_(quarter_back_, back_);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      times(turn_, n_ + p_, Y_[k], product_);
      product_ += Y_[k];
      if (!turns_back) {
        Y_[k + 1] = product_;
        continue;
      }
      times(product_, n_, back_, Y_[k + 1]);
      Y_[k + 1] += product_;
    }
  }

  /// Returns the miss at t = 1, taken back to t = 0.
  MatrixXd carried_back() {
    MatrixXd D = Y_[4] - T_;
    for (std::size_t node = 5; node-- > 0;) project(Y_[node], D);
    return D;
  }

  /// Removes from D what is not tangent at Y.
  void project(const MatrixXd& Y, MatrixXd& D) {
    transposed_.topRows(n_) = Y.topRows(n_ + p_).transpose();
    times(transposed_, n_ + p_, D, S_);
    back_.topRows(n_) = (S_.topRows(n_) + S_.topRows(n_).transpose()) / 2;
    times(Y, n_, back_, product_);
    D -= product_;
  }

  /// Sets out = AB, n columns, for padded matrices, of which A has k columns.
  void times(const MatrixXd& A, Index k, const MatrixXd& B, MatrixXd& out) const {
    multiply_(A.rows(), k, n_, A.data(), A.rows(), B.data(), B.rows(), out.data(), out.rows());
  }

  void unpack(const VectorXd& x) {
    V_.setZero();
    Index at = 0;
    for (Index j = 0; j < n_; ++j)
      for (Index i = 0; i < j; ++i) {
        V_(i, j) = x(at++) / std::sqrt(2.0);
        V_(j, i) = -V_(i, j);
      }
    V_.middleRows(n_, p_) = x.tail(p_ * n_).reshaped(p_, n_);
  }

  Index n_, p_;
  double beta_;
  MatrixXd T_, V_, W_, turn_, back_, quarter_back_, S_, product_, transposed_;
  std::array<MatrixXd, 5> Y_;
  NewtonKrylov<double> newton_;
  SmallExponential exp_W_, exp_A_;
  SmallProduct multiply_ = small_product();
};

/// Joins two frames, n × (n + p), by a geodesic with a velocity x. Returns its frame at k/4; empty
/// where none was found.
MatrixXd join(RoundShooting& shooting, const MatrixXd& from, const MatrixXd& to, std::size_t k,
              VectorXd& x) {
  MatrixXd axes(from.cols(), from.cols());
  axes << from, complement(from);
  shooting.set_target(axes * to.transpose());
  x = shooting.chord();
  if (!shooting.converge(x) && !shooting.minimise(x = shooting.chord())) return {};
  shooting.shoot(x);
  return shooting.frame(k).transpose() * axes;
}

/// Finds a geodesic with the velocity x from the identity to a frame, whose first part of 1/parts
/// ends near `first`, and which is no longer than so many times the geodesic to `first`.
bool prolong(RoundShooting& shooting, const MatrixXd& first, int parts, const MatrixXd& T,
             VectorXd& x) {
  if (join(shooting, MatrixXd::Identity(T.rows(), T.cols()), first, 4, x).size() == 0) return false;
  const double longest = (1 + 1e-9) * parts * shooting.length();
  x *= parts;
  shooting.set_target(T.transpose());
  return shooting.minimise(x) && std::isfinite(shooting.shoot(x)) && shooting.length() <= longest;
}

/// Shortens a broken geodesic until it has no kinks (Noakes 1998): every second frame of the path
/// moves to the middle of a geodesic between its neighbours, then the others do. Where this moves
/// them little, tries to prolong the first piece. A path that comes near to a geodesic which is no
/// minimum of the length leaves it slowly.
bool straighten(RoundShooting& shooting, Path path, VectorXd& x) {
  constexpr int most = 400;
  const int steps = static_cast<int>(path.size()) - 1;
  double much = 0.01;
  for (int sweep = 0; sweep < most; ++sweep) {
    double moved = 0;
    for (const std::size_t first : {1, 2})
      for (std::size_t k = first; k + 1 < path.size(); k += 2) {
        MatrixXd middle = join(shooting, path[k - 1], path[k + 1], 2, x);
        if (middle.size() == 0) return false;
        moved = std::max(moved, (middle - path[k]).norm());
        path[k] = std::move(middle);
      }
    if (!(moved < much)) continue;
    if (prolong(shooting, path[1], steps, path.back(), x)) return true;
    much = moved / 4;
  }
  return false;
}

/// Returns a proved lower bound of the injectivity radius in the norm of β, where one is known:
/// π for β = 1 (Zimmermann and Stoye 2024) and √(4/5) π for β = 1/2 (Rentmeesters 2013).
double least_radius(double beta) {
  constexpr double rounding = 1 + 1e-12;
  if (beta == 1) return rounding * std::numbers::pi;
  return beta == 0.5 ? std::sqrt(0.8) * std::numbers::pi : 0;
}

}  // namespace

void round_logarithm(const MatrixXd& Q_0, const MatrixXd& Q_T, const FrameProducts& products,
                     const TwoPointProblem& problem, Found& best) {
  constexpr double same = 1e-6;
  const double beta = problem.beta.value_or(1);
  const FrameSpan span(Q_0, Q_T, products);
  RoundShooting shooting(span.target(), beta);
  std::vector<VectorXd> found;
  const auto keep = [&](const VectorXd& x, int start) {
    if (std::ranges::any_of(found, [&](const VectorXd& y) { return (x - y).norm() <= same; }))
      return;
    found.push_back(x);
    best.distinct = static_cast<int>(found.size());
    stop_point(2 * connect_work::frame(Q_0.rows(), Q_0.cols()));
    shooting.set_target(span.target());
    shooting.shoot(x);
    if (best.length && !(shooting.length() < *best.length)) return;
    best.length = shooting.length();
    best.start = start;
    best.V = span.lifted(shooting.V());
    best.residual = (shooting.frame(4) - span.target()).colwise().norm().maxCoeff();
    best.shortest = *best.length <= least_radius(beta) ? Shortest::yes : Shortest::unknown;
  };
  const VectorXd chord = shooting.chord();
  VectorXd x = chord;
  const bool there = chord.norm() > 0 && shooting.converge(x);
  if (there) keep(x, 0);
  if (!(there && best.shortest == Shortest::yes)) {
    const MatrixXd T = span.target().transpose(), I = MatrixXd::Identity(T.rows(), T.cols());
    const MatrixXd near = join(shooting, T, I, 3, x);
    const bool back = near.size() > 0 && prolong(shooting, near, 4, T, x);
    if (back) keep(x, 0);
    for (int steps = 4; steps <= 16 && !(there && back); steps *= 2) {
      const VectorXd times = VectorXd::LinSpaced(steps + 1, 0, 1);
      if (!straighten(shooting, starts(I, T, times, 0, problem.seed, false)[0], x)) continue;
      keep(x, 0);
      break;
    }
    shooting.set_target(span.target());
  }
  std::mt19937_64 generator(problem.seed);
  std::normal_distribution<double> normal;
  for (int k = 1; k <= problem.restarts && best.shortest != Shortest::yes; ++k) {
    for (double& number : x) number = normal(generator);
    x = chord + (std::numbers::pi / x.norm()) * x;
    VectorXd other = x;
    if (shooting.converge(x) || shooting.minimise(x = other)) keep(x, k);
  }
}

}  // namespace stiefel
