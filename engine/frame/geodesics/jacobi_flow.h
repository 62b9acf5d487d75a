#pragma once

#include <Eigen/Core>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <memory>
#include <vector>

namespace stiefel {

/// The geodesic flow of tr(ΛQ̇ᵀQ̇) with m Jacobi fields, in steps of the pair of Fehlberg of orders 7
/// and 8. Fields are read in an orthonormal basis E_i of the tangent space at Q(t),
///
///     A_ik = ⟨E_i, J_k⟩,   B_ik = ⟨E_i, D_tJ_k⟩,
///
/// D_t the covariant derivative; AᵀB is symmetric where every J_k(0) = 0. For n < N, D_tJ is the
/// tangent part of δQ̇ in R^{nN}, and B_ik = tr(δS_k E_iᵀ). For n = N, with η = QᵀδQ,
///
///     J(D_tη) = δM − ½[M, η] + ½(J[η, Ω] − [Jη, Ω]),   J(Ω) = ΛΩ + ΩΛ .
class JacobiFlow {
 public:
  using State = std::vector<double>;

  /// n < N: every λ_i > 0; n = N: λ_i + λ_j > 0 for i ≠ j.
  static std::unique_ptr<JacobiFlow> make(const Eigen::VectorXd& lambda, Eigen::Index n);
  virtual ~JacobiFlow() = default;

  /// Returns the state with J_k(0) = 0 and D_tJ_k(0) = the columns of `directions`, nN × m, tangent
  /// at Q.
  State start(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& V,
              const Eigen::MatrixXd& directions) const;
  /// Returns d orthonormal tangent vectors at Q, each as a column of length nN.
  virtual Eigen::MatrixXd basis(const Eigen::MatrixXd& Q) const = 0;
  /// Computes the state after a time h, and an estimate of its error.
  void step(const State& x, double h, State& next, State& error);

  struct Coordinates {
    Eigen::MatrixXd A, B;
  };
  virtual Coordinates coordinates(const State& x) const = 0;
  /// Returns a bound of √|K|, K the sectional curvatures of planes with Q̇ at x, for unit speed.
  virtual double curvature(const State& x) const = 0;

  /// The fields, each as a column of δQ over the variation of the momentum.
  Eigen::Map<Eigen::MatrixXd> fields(State& x) const {
    const Eigen::Index both = 2 * n_ * N_, all = static_cast<Eigen::Index>(x.size());
    return {x.data() + both, both, all / both - 1};
  }
  Eigen::Index degrees() const { return n_ * N_ - n_ * (n_ + 1) / 2; }

 protected:
  using Block = Eigen::Map<Eigen::MatrixXd>;
  using Values = Eigen::Map<const Eigen::MatrixXd>;

  JacobiFlow(const Eigen::VectorXd& lambda, Eigen::Index n)
      : lambda_(lambda), n_(n), N_(lambda.size()) {}

  /// Return block k of a state, of Q, p, and δQ, δp for each field, n × N; p is S for n < N, M for
  /// n = N.
  Values block(const State& x, std::size_t k) const {
    return {x.data() + k * static_cast<std::size_t>(n_ * N_), n_, N_};
  }
  Block block(State& x, std::size_t k) const {
    return {x.data() + k * static_cast<std::size_t>(n_ * N_), n_, N_};
  }

  /// Sets the derivatives of Q and p, then those of δQ and δp at the point of the last call.
  virtual void field(const Values& Q, const Values& p, Block dQ, Block dp) = 0;
  virtual void variation(const Values& Q, const Values& p, const Values& q, const Values& r,
                         Block dq, Block dr) = 0;

  Eigen::VectorXd lambda_;
  Eigen::Index n_, N_;

 private:
  boost::numeric::odeint::runge_kutta_fehlberg78<State> fehlberg_;
};

}  // namespace stiefel
