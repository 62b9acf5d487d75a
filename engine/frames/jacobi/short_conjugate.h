#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "engine/frames/jacobi/conjugate_search.h"
#include "engine/frames/jacobi/jacobi_flow.h"

namespace stiefel {

/// A geodesic of unit speed and its first conjugate point.
struct Conjugated {
  Eigen::MatrixXd Q, V;
  Crossing point;
};

/// Looks for the least distance c of a first conjugate point over all geodesics of unit speed.
/// Where w and u = D_tJw/|D_tJw| are the kernel and the cokernel of J(c), a change ξ of (Q, V)
/// changes c by −∂_ξ⟨u, J(c)w⟩ / |D_tJw|, for which one Jacobi field is followed for each ξ.
class ShortConjugates {
 public:
  ShortConjugates(const Eigen::VectorXd& lambda, Eigen::Index n);

  /// Returns the first conjugate point of the geodesic from (Q, V) up to `limit`, if any.
  std::optional<Conjugated> first(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& V,
                                  double limit) const;
  /// Descends from a geodesic by the method of Broyden, Fletcher, Goldfarb and Shanno.
  Conjugated descended(Conjugated from);
  /// Returns the state after `length`, with the fields of x; empty where it is not reached.
  std::optional<JacobiFlow::State> moved(JacobiFlow::State x, double length) const;
  const JacobiFlow& flow() const { return *flow_; }
  /// Returns the tangent vector of unit speed at Q nearest to V.
  Eigen::MatrixXd unit(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& V) const;

 private:
  Eigen::VectorXd gradient(const Conjugated& at) const;

  Eigen::VectorXd lambda_;
  Eigen::Index n_, N_;
  std::unique_ptr<JacobiFlow> flow_;
};

}  // namespace stiefel
