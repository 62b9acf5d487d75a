#include "engine/frame/geodesics/relaxation.h"

#include <algorithm>
#include <cmath>

#include "engine/dense/decompositions.h"
#include "engine/frame/geodesics/connect_work.h"
#include "stiefel/stop.h"

namespace stiefel {

namespace {

double real(Index k) { return static_cast<double>(k); }

}  // namespace

Relaxation::Relaxation(const VectorXd& lambda, const MatrixXd& Q_0, const MatrixXd& Q_T,
                       const Nodes& nodes)
    : Q_0_(Q_0),
      Q_T_(Q_T),
      nodes_(nodes),
      n_(Q_0.rows()),
      N_(Q_0.cols()),
      K_(nodes.inner()),
      unknowns_(K_ * n_ * (n_ + 1) / 2) {
  set_inertia(lambda);
}

void Relaxation::set_inertia(const VectorXd& lambda) {
  lambda_ = lambda;
  shift_ = 0;
  if (q_.size() > 0) measure();
}

void Relaxation::set_path(const Path& path) {
  q_.resize(K_ * n_, N_);
  for (Index k = 0; k < K_; ++k) node(q_, k) = path[static_cast<std::size_t>(k + 1)];
  shift_ = 0;
  shifted_ = false;
  measure();
}

Path Relaxation::path() const {
  Path path = {Q_0_};
  for (Index k = 0; k < K_; ++k) path.push_back(node(q_, k));
  path.push_back(Q_T_);
  return path;
}

/// Computes the action and its gradient.
void Relaxation::measure() {
  stop_point(1000 + 4 * real(n_ * N_ * (K_ + 2) * (K_ + 2)));
  gradient_.resize(K_ * n_, N_);
  MatrixXd all(n_, K_ + 2), forces(all);
  double twice = 0;
  for (Index j = 0; j < N_; ++j) {
    all << Q_0_.col(j), q_.col(j).reshaped(n_, K_), Q_T_.col(j);
    forces.noalias() = all * nodes_.stiffness;
    twice += lambda_(j) * all.cwiseProduct(forces).sum();
    gradient_.col(j).reshaped(n_, K_) = lambda_(j) * forces.middleCols(1, K_);
  }
  action_ = twice / 2;
}

/// Computes the multipliers, ρ and the eigenvalue problem at the path.
void Relaxation::model() {
  const Index m = K_ * n_;
  stop_point(10000 + 30 * real(m * m * m));
  rho_ = gradient_;
  Gamma_.resize(n_, m);  // w_kΓ_k side by side
  for (Index k = 0; k < K_; ++k) {
    const MatrixXd g = node(gradient_, k) * node(q_, k).transpose();
    Gamma_.middleCols(k * n_, n_) = -(g + g.transpose()) / 2;
    node(rho_, k).noalias() += Gamma_.middleCols(k * n_, n_) * node(q_, k);
  }
  const MatrixXd& root = nodes_.inverse_root;
  MatrixXd scaled = MatrixXd::Zero(m, m);
  for (Index k = 0; k < K_; ++k)
    for (Index l = 0; l <= k; ++l) {
      auto block = scaled.block(k * n_, l * n_, n_, n_);
      for (Index i = 0; i < K_; ++i)
        block += root(k, i) * root(i, l) * Gamma_.middleCols(i * n_, n_);
    }
  const SymmetricEigen eigen = symmetric_eigen(scaled);
  d_ = eigen.values;
  X_.resize(m, m);
  for (Index c = 0; c < m; ++c)
    X_.col(c).reshaped(n_, K_).noalias() = eigen.vectors.col(c).reshaped(n_, K_) * root;
}

/// Returns sym(Q_k δQ_kᵀ) of every node, its entries above the diagonal times √2, of some columns
/// q of the frames and δ of δQ.
VectorXd Relaxation::constraint(const Eigen::Ref<const MatrixXd>& q,
                                const Eigen::Ref<const MatrixXd>& delta) const {
  VectorXd out(unknowns_);
  Index at = 0;
  for (Index k = 0; k < K_; ++k) {
    const MatrixXd both = q.middleRows(k * n_, n_) * delta.middleRows(k * n_, n_).transpose();
    for (Index b = 0; b < n_; ++b) {
      for (Index a = 0; a < b; ++a) out(at++) = (both(a, b) + both(b, a)) / std::sqrt(2.0);
      out(at++) = both(b, b);
    }
  }
  return out;
}

/// Sets the lower part of M = C H⁻¹ Cᵀ in the coordinates of `constraint`. For two nodes k and l
/// it is Σ_j q_jk,a q_jl,d (H_j⁻¹)_kb,lc, symmetric in ab and in cd.
void Relaxation::assemble(const MatrixXd& inverse) {
  const Index square = n_ * n_, m = K_ * n_;
  M_.resize(unknowns_, unknowns_);
  MatrixXd of_X(square, m), H(square, N_), B(square, N_), W(square, square);
  const Index each = n_ * (n_ + 1) / 2;
  for (Index k = 0; k < K_; ++k)
    for (Index l = 0; l <= k; ++l) {
      stop_point(2000 + 3 * real(square * (m + square + 1) * (N_ + 4)));
      for (Index c = 0; c < m; ++c)
        of_X.col(c).reshaped(n_, n_).noalias() =
            X_.col(c).segment(k * n_, n_) * X_.col(c).segment(l * n_, n_).transpose();
      H.noalias() = of_X * inverse;
      for (Index j = 0; j < N_; ++j)
        B.col(j).reshaped(n_, n_).noalias() =
            q_.col(j).segment(k * n_, n_) * q_.col(j).segment(l * n_, n_).transpose();
      W.noalias() = B * H.transpose();
      const auto w = [&](Index a, Index d, Index b, Index c) { return W(a + n_ * d, b + n_ * c); };
      Index column = l * each;
      for (Index d = 0; d < n_; ++d)
        for (Index c = 0; c <= d; ++c, ++column) {
          Index row = k * each;
          for (Index b = 0; b < n_; ++b)
            for (Index a = 0; a <= b; ++a, ++row) {
              const double scale = (a == b ? 1 : std::sqrt(2.0)) * (c == d ? 1 : std::sqrt(2.0));
              M_(row, column) =
                  scale / 4 * (w(a, d, b, c) + w(b, d, a, c) + w(a, c, b, d) + w(b, c, a, d));
            }
        }
    }
}

/// Factors the equations. Returns false where the shifted Hessian is not positive along the frames.
bool Relaxation::solve(double shift) {
  inverse_.resize(K_ * n_, N_);
  for (Index j = 0; j < N_; ++j)
    inverse_.col(j) = (d_.array() + (1 + shift) * lambda_(j)).cwiseInverse();
  const Index negative = (inverse_.array() < 0).count();
  if (negative > unknowns_ || !inverse_.allFinite()) return false;
  if (unknowns_ > most_dense) return negative == 0;
  assemble(inverse_.cwiseMax(0));
  constexpr double instructions = 0.7;  // of a factorisation, times the cube of its size
  stop_point(instructions * real(unknowns_ * unknowns_ * unknowns_));
  if (!factor_positive(M_)) return false;
  subtract_negative(negative);
  stop_point(instructions * real(negative * negative * negative));
  return negative == 0 || factor_positive(capacity_);
}

/// Sets Y and the capacity YᵀY − I of M = L(I − YYᵀ)Lᵀ, with a column of LY for each negative
/// eigenvalue of an H_j.
void Relaxation::subtract_negative(Index negative) {
  Y_.resize(unknowns_, negative);
  if (negative == 0) return;
  Index at = 0;
  for (Index j = 0; j < N_; ++j)
    for (Index c = 0; c < X_.cols(); ++c) {
      if (!(inverse_(c, j) < 0)) continue;
      stop_point(1000 + 4 * real(n_ * K_ * (K_ + 2)));
      Y_.col(at++) = std::sqrt(-inverse_(c, j)) * constraint(q_.col(j), X_.col(c));
    }
  divide_by_lower(M_, Y_);
  stop_point(3000 + real(unknowns_ * negative * (negative + 20)));
  capacity_ = -MatrixXd::Identity(negative, negative);
  capacity_.selfadjointView<Eigen::Lower>().rankUpdate(Y_.transpose());
}

/// Returns H⁻¹ of the columns of `right`.
MatrixXd Relaxation::solved(const MatrixXd& right) const {
  stop_point(5000 + real(K_ * n_ * K_ * n_ * (8 * N_ + n_ * n_)));
  return X_ * inverse_.cwiseProduct(X_.transpose() * right);
}

/// Adds γ_kQ_k to every node.
void Relaxation::add_forces(const VectorXd& gamma, MatrixXd& out) const {
  MatrixXd each(n_, n_);
  Index at = 0;
  for (Index k = 0; k < K_; ++k) {
    for (Index b = 0; b < n_; ++b) {
      for (Index a = 0; a < b; ++a) each(a, b) = each(b, a) = gamma(at++) / std::sqrt(2.0);
      each(b, b) = gamma(at++);
    }
    node(out, k).noalias() += each * node(q_, k);
  }
}

/// Solves C H⁻¹ Cᵀ γ = right.
VectorXd Relaxation::multipliers(const VectorXd& right) const {
  if (unknowns_ <= most_dense) {
    VectorXd x = right;
    M_.triangularView<Eigen::Lower>().solveInPlace(x);
    if (Y_.cols() > 0) {
      VectorXd y = Y_.transpose() * x;
      capacity_.triangularView<Eigen::Lower>().solveInPlace(y);
      capacity_.transpose().triangularView<Eigen::Upper>().solveInPlace(y);
      x.noalias() -= Y_ * y;
    }
    M_.transpose().triangularView<Eigen::Upper>().solveInPlace(x);
    return x;
  }
  constexpr int most = 400;
  constexpr double accuracy = 1e-9;
  const Index each = n_ * (n_ + 1) / 2;
  const MatrixXd S = nodes_.stiffness.block(1, 1, K_, K_);
  VectorXd gamma = VectorXd::Zero(unknowns_), rest = right, direction, preconditioned(unknowns_);
  double before = 0;
  for (int k = 0; k < most && rest.norm() > accuracy * right.norm(); ++k) {
    preconditioned.reshaped(each, K_).noalias() = rest.reshaped(each, K_) * S;
    const double now = rest.dot(preconditioned);
    direction = k == 0 ? preconditioned : VectorXd(preconditioned + now / before * direction);
    before = now;
    MatrixXd forces = MatrixXd::Zero(K_ * n_, N_);
    add_forces(direction, forces);
    const VectorXd image = constraint(q_, solved(forces));
    const double length = now / direction.dot(image);
    gamma += length * direction;
    rest -= length * image;
  }
  return gamma;
}

/// Returns the δq with sym(Q_kδQ_kᵀ) = 0 that solve Newton's equations with ρ.
MatrixXd Relaxation::step(const MatrixXd& rho) const {
  MatrixXd all = rho;
  add_forces(multipliers(-constraint(q_, solved(rho))), all);
  return -solved(all);
}

void Relaxation::retract() {
  for (Index k = 0; k < K_; ++k) {
    stop_point(connect_work::frame(n_, N_));
    node(q_, k) = polar(node(q_, k));
  }
}

bool Relaxation::relax(double tolerance, int most, double largest) {
  constexpr double smallest = 0.05;
  const double rounding =
      1e-15 * nodes_.stiffness.trace() * lambda_.maxCoeff() * static_cast<double>(n_);
  for (int iteration = 0; iteration < most; ++iteration) {
    model();
    const MatrixXd before = q_, gradient = gradient_;
    const double action = action_;
    double size = 0;
    for (;; shift_ = std::max(4 * shift_, smallest)) {
      if (!(shift_ <= largest)) return false;
      if (!solve(shift_)) continue;
      const MatrixXd delta = step(rho_);
      size = delta.cwiseAbs().maxCoeff();
      if (!std::isfinite(size)) continue;
      q_ = before + delta;
      retract();
      measure();
      if (action_ <= action + rounding) break;
      q_ = before;
      gradient_ = gradient;
      action_ = action;
    }
    shifted_ = shifted_ || shift_ > 0;
    if (size <= tolerance && shift_ == 0) return true;
    shift_ = shift_ > smallest ? shift_ / 8 : 0;
  }
  return false;
}

MatrixXd Relaxation::tangent(MatrixXd V) const {
  const MatrixXd both = V * Q_0_.transpose();
  V.noalias() -= (both + both.transpose()) / 2 * Q_0_;
  return V;
}

MatrixXd Relaxation::velocity() const {
  MatrixXd V = nodes_.start(0) * Q_0_ + nodes_.start(K_ + 1) * Q_T_;
  for (Index k = 0; k < K_; ++k) V += nodes_.start(k + 1) * node(q_, k);
  return tangent(std::move(V));
}

MatrixXd Relaxation::response(const MatrixXd& end) const {
  MatrixXd rho(K_ * n_, N_);
  for (Index k = 0; k < K_; ++k)
    node(rho, k) = nodes_.stiffness(k + 1, K_ + 1) * end * lambda_.asDiagonal();
  const MatrixXd delta = step(rho);
  MatrixXd V = nodes_.start(K_ + 1) * end;
  for (Index k = 0; k < K_; ++k) V += nodes_.start(k + 1) * node(delta, k);
  return tangent(std::move(V));
}

}  // namespace stiefel
