#include "engine/dense/inertia_operator.h"
#include "engine/frame/stiefel_legendre.h"
#include "engine/motion/representation.h"

namespace stiefel {
namespace {

constexpr Eigen::Index largest_written = 4096;

/// Returns Q̇, from M where n = N, else from S.
Eigen::MatrixXd Qdot_of(const Phase& x) {
  return x.square() ? Eigen::MatrixXd(x.Q * inverse_inertia(x.lambda, x.M))
                    : Qdot_of_S(x.lambda, x.S);
}
WithinDomain<FormBlocks> write_velocity(const Phase& x, const ConversionTarget&, Margins&) {
  return FormBlocks{{{"Q", x.Q}, {"Qdot", Qdot_of(x)}}};
}

/// Writes U by 𝒵, [ST] Theorem 2.
WithinDomain<FormBlocks> write_angular_velocity(const Phase& x, const ConversionTarget&, Margins&) {
  if (x.square()) return FormBlocks{{{"Q", x.Q}, {"U", x.Q.transpose() * Qdot_of(x)}}};
  const auto N = static_cast<double>(x.Q.cols());
  if (x.Q.cols() > largest_written) return outside({"N", N, largest_written}, "to");
  OptimalControl<double> U(x.lambda, x.Q.rows());
  U.set(x.Q, x.S);
  return FormBlocks{{{"Q", x.Q}, {"U", U.dense()}}};
}

}  // namespace

namespace representations {
constinit const Representation velocity = {false, nullptr, write_velocity};
constinit const Representation angular_velocity = {false, nullptr, write_angular_velocity};
}  // namespace representations

}  // namespace stiefel
