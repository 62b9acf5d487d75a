#include "engine/rigid_body/body/angular_velocity.h"
#include "engine/rigid_body/moser_veselov/discrete_pairs.h"
#include "engine/rigid_body/body/rigid_velocity.h"
#include "engine/frames/body/stiefel_legendre.h"
#include "engine/frames/body/stiefel_momenta.h"
#include "engine/catalogue/representations/phase.h"
#include "engine/catalogue/representations/representations.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

constexpr Eigen::Index largest_written = 4096;

/// Returns the phase of Q and any costate P, for example S: S by 𝔐⁻¹, at n = N only M.
Phase phase(const Scene& scene, const Dense& Q, const Dense& P) {
  Phase x{scene.inertia(), scene.step(), Q, {}, {}};
  if (x.square())
    x.M = dense_M(Q, P);
  else
    x.S = Legendre_inverse(x.lambda, Q, P);
  return x;
}
Dense S_of(const Phase& x) {
  return x.square() ? S_of_Qdot<double>(x.lambda, Qdot_of_M(x.lambda, x.Q, x.M)) : x.S;
}

WithinDomain<Phase> read_tangent(const Scene& scene, Margins&) {
  Phase x = phase(scene, scene.Q(), scene.block("S"));
  if (!x.square()) x.S = scene.block("S");
  return x;
}
WithinDomain<Expression> write_tangent(const Phase& x, const ConversionTarget&, Margins&) {
  return Expression{{{"Q", x.Q}, {"S", S_of(x)}}};
}

/// Reads (Q, P). stiefel_momentum, [ST] (82), uses it too, because it holds P_0.
WithinDomain<Phase> read_costate(const Scene& scene, Margins&) {
  return phase(scene, scene.Q(), scene.block("P"));
}
/// Writes P_0 by 𝔐, [ST] Prop. 6.
WithinDomain<Expression> write_costate(const Phase& x, const ConversionTarget&, Margins&) {
  return Expression{{{"Q", x.Q}, {"P", Legendre(x.Q, S_of(x))}}};
}
WithinDomain<Expression> write_momentum(const Phase& x, const ConversionTarget&, Margins&) {
  const auto N = static_cast<double>(x.Q.cols());
  if (x.Q.cols() > largest_written) return outside({"N", N, largest_written}, "to");
  return Expression{{{"Q", x.Q}, {"M", dense_M(x.Q, S_of(x))}}};
}

/// Reads (q, p) or (q, qdot), n = 1.
WithinDomain<Phase> read_vector(const Scene& scene, Margins&) {
  const Dense &q = scene.block("q"), &p = scene.block("p");
  if (p.size() > 0) return phase(scene, q, p);
  Phase x{scene.inertia(), scene.step(), q, {}, {}};
  x.S = S_of_Qdot<double>(x.lambda, scene.block("qdot"));
  return x;
}
WithinDomain<Expression> write_vector(const Phase& x, const ConversionTarget&, Margins&) {
  const auto n = static_cast<double>(x.Q.rows());
  if (x.Q.rows() != 1) return outside({"V(1, N)", n, 1}, "to");
  return Expression{{{"q", x.Q}, {"qdot", Qdot_of_S(x.lambda, x.S)}}};
}

/// Returns Q̇, from M where n = N, else from S.
Dense Qdot_of(const Phase& x) {
  return x.square() ? Qdot_of_M(x.lambda, x.Q, x.M) : Qdot_of_S(x.lambda, x.S);
}
WithinDomain<Expression> write_velocity(const Phase& x, const ConversionTarget&, Margins&) {
  return Expression{{{"Q", x.Q}, {"Qdot", Qdot_of(x)}}};
}

/// Writes U by 𝒵, [ST] Theorem 2.
WithinDomain<Expression> write_angular_velocity(const Phase& x, const ConversionTarget&, Margins&) {
  if (x.square()) return Expression{{{"Q", x.Q}, {"U", x.Q.transpose() * Qdot_of(x)}}};
  const auto N = static_cast<double>(x.Q.cols());
  if (x.Q.cols() > largest_written) return outside({"N", N, largest_written}, "to");
  return Expression{{{"Q", x.Q}, {"U", AngularVelocity<double>(x.lambda, x.Q, x.S).dense()}}};
}

/// Adds the margin of two frames as a representation of M ≠ 0.
void add_condition(const Phase& x, Margins& margins) {
  if (!x.M.isZero(0))
    margins.push_back({"1/condition of M", inverse_condition_Sigma_L(x.lambda, x.M, x.step)});
}

/// Reads two frames for n = N, where (55) is the map of Moser and Veselov. For n < N it is a motion
/// of its own, and refused.
WithinDomain<Phase> read_two_frames(const Scene& scene, Margins& margins) {
  const Dense &Q_prev = scene.block("Q_prev"), &Q = scene.Q();
  if (Q.rows() != Q.cols())
    return outside({"n = N", static_cast<double>(Q.rows()), static_cast<double>(Q.cols())},
                   "initial.Q");
  margins.push_back({"S_L", margin_S_L(scene.inertia(), Q_prev, Q)});
  Phase x{scene.inertia(), scene.step(), Q, {}, {}};
  x.M = Sigma_L(x.lambda, Q_prev, Q, x.step);
  add_condition(x, margins);
  return x;
}
WithinDomain<Expression> write_two_frames(const Phase& x, const ConversionTarget&,
                                          Margins& margins) {
  if (!x.square())
    return outside({"n = N", static_cast<double>(x.Q.rows()), static_cast<double>(x.Q.cols())},
                   "to");
  auto Q_prev = Sigma_L_inverse(x.lambda, x.Q, x.M, x.step);
  if (!Q_prev) return outside(Q_prev.error(), "step");
  margins.push_back({"S_L", margin_S_L(x.lambda, *Q_prev, x.Q)});
  add_condition(x, margins);
  return Expression{{{"Q_prev", std::move(*Q_prev)}, {"Q", x.Q}}};
}

}  // namespace

namespace representation {
constinit const Representation tangent = {false, read_tangent, write_tangent};
constinit const Representation costate = {false, read_costate, write_costate};
constinit const Representation momentum = {false, read_costate, write_momentum};
constinit const Representation vector = {false, read_vector, write_vector};
constinit const Representation frames = {false, read_two_frames, write_two_frames};
constinit const Representation velocity = {false, nullptr, write_velocity};
constinit const Representation angular_velocity = {false, nullptr, write_angular_velocity};
}  // namespace representation

}  // namespace stiefel
