#pragma once

#include <algorithm>
#include <vector>

#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/frame/geodesics/connect_work.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The geodesic flow with any number of its variations. A state is the n × N blocks Q over p, then
/// δQ over δp for each variation. p is the momentum: S for n < N, M for n = N. A form gives the
/// vector field and its derivative, and sets whole blocks.
///
/// FrameForm is the form for n < N ([ST] (37)–(39)): Q̇ = SΛ⁻¹, Ṡ = BQ, KB + BK = −2Q̇Q̇ᵀ, K =
/// QΛ⁻¹Qᵀ.
template <class Scalar>
class FrameForm {
 public:
  FrameForm(const Vector<Scalar>& lambda, Eigen::Index n) : lambda_(lambda), n_(n) {}

  template <class Q_, class S_, class A, class B>
  void field(const Q_& Q, const S_& S, A dQ, B dS) {
    V_ = S * lambda_.cwiseInverse().asDiagonal();
    G_ = Q * lambda_.cwiseInverse().asDiagonal();
    K_ = G_.lazyProduct(Q.transpose()).template triangularView<Eigen::Lower>();
    spectrum_.factor(K_);
    B_ = divided(-2 * V_.lazyProduct(V_.transpose()));
    dQ = V_;
    dS = B_.lazyProduct(Q);
  }

  /// Computes the derivative at the point of the last call of `field`.
  template <class Q_, class S_, class q_, class s_, class A, class B>
  void variation(const Q_& Q, const S_&, const q_& q, const s_& s, A dq, B ds) {
    const Matrix<Scalar> v = s * lambda_.cwiseInverse().asDiagonal(),
                         half_k = q.lazyProduct(G_.transpose()), k = half_k + half_k.transpose(),
                         kB = k.lazyProduct(B_), vV = v.lazyProduct(V_.transpose());
    const Matrix<Scalar> b = divided(-2 * (vV + vV.transpose()) - kB - kB.transpose());
    dq = v;
    ds = b.lazyProduct(Q) + B_.lazyProduct(q);
  }

  /// Returns S = VΛ, V = Q̇.
  static Matrix<Scalar> momentum(const Vector<Scalar>& lambda, const Matrix<Scalar>&,
                                 const Matrix<Scalar>& V) {
    return V * lambda.asDiagonal();
  }

 private:
  /// Returns X with KX + XK = E.
  Matrix<Scalar> divided(const Matrix<Scalar>& E) const {
    const auto& Z = spectrum_.vectors();
    const auto& kappa = spectrum_.values();
    const Matrix<Scalar> EZ = E.lazyProduct(Z);
    Matrix<Scalar> X = Z.transpose().lazyProduct(EZ);
    for (Eigen::Index j = 0; j < n_; ++j)
      for (Eigen::Index i = 0; i < n_; ++i) X(i, j) /= kappa(i) + kappa(j);
    const Matrix<Scalar> XZ = X.lazyProduct(Z.transpose());
    return Z.lazyProduct(XZ);
  }

  Vector<Scalar> lambda_;
  Eigen::Index n_;
  SymmetricEigen<Scalar> spectrum_;
  Matrix<Scalar> V_, G_, K_, B_;
};

/// The form for n = N ([RB] (2.2), (2.3)): Q̇ = QΩ, Ṁ = [M, Ω], Ω_ij = M_ij/(λ_i + λ_j). No λ_i is
/// a divisor.
template <class Scalar>
class BodyForm {
 public:
  BodyForm(const Vector<Scalar>& lambda, Eigen::Index) : lambda_(lambda) {}

  template <class Q_, class M_, class A, class B>
  void field(const Q_& Q, const M_& M, A dQ, B dM) {
    Omega_ = divided(M);
    dQ = Q.lazyProduct(Omega_);
    dM = M.lazyProduct(Omega_) - Omega_.lazyProduct(M);
  }

  template <class Q_, class M_, class q_, class m_, class A, class B>
  void variation(const Q_& Q, const M_& M, const q_& q, const m_& m, A dq, B dm) {
    const Matrix<Scalar> omega = divided(m);
    dq = q.lazyProduct(Omega_) + Q.lazyProduct(omega);
    dm =
        m.lazyProduct(Omega_) - Omega_.lazyProduct(m) + M.lazyProduct(omega) - omega.lazyProduct(M);
  }

  /// Returns M = ΛΩ + ΩΛ, Ω the skew part of QᵀQ̇.
  static Matrix<Scalar> momentum(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                                 const Matrix<Scalar>& V) {
    const Matrix<Scalar> twice = Q.transpose().lazyProduct(V) - V.transpose().lazyProduct(Q);
    return (lambda.asDiagonal() * twice + twice * lambda.asDiagonal()) / Scalar(2);
  }

 private:
  template <class M_>
  Matrix<Scalar> divided(const M_& M) const {
    return inverse_inertia<Scalar>(lambda_, M);
  }

  Vector<Scalar> lambda_;
  Matrix<Scalar> Omega_;
};

/// A form as a vector field on the plain vector of numbers that the integrator needs.
template <class Form, class Scalar>
class GeodesicField {
 public:
  using State = std::vector<Scalar>;

  GeodesicField(const Vector<Scalar>& lambda, Eigen::Index n)
      : form_(lambda, n), n_(n), N_(lambda.size()) {}

  void operator()(const State& x, State& dx) {
    form_.field(block(x, 0), block(x, 1), block(dx, 0), block(dx, 1));
    const std::size_t blocks = x.size() / static_cast<std::size_t>(n_ * N_);
    for (std::size_t k = 2; k < blocks; k += 2) {
      stop_point(1.5 * connect_work::frame(n_, N_));
      form_.variation(block(x, 0), block(x, 1), block(x, k), block(x, k + 1), block(dx, k),
                      block(dx, k + 1));
    }
  }

  Eigen::Map<const Matrix<Scalar>> block(const State& x, std::size_t k) const {
    return {x.data() + k * static_cast<std::size_t>(n_ * N_), n_, N_};
  }
  Eigen::Map<Matrix<Scalar>> block(State& x, std::size_t k) const {
    return {x.data() + k * static_cast<std::size_t>(n_ * N_), n_, N_};
  }

 private:
  Form form_;
  Eigen::Index n_, N_;
};

}  // namespace stiefel
