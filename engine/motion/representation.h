#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/motion/outside_domain.h"
#include "stiefel/conversion.h"

namespace stiefel {

/// A state in the variables through which all forms are converted.
struct Phase {
  Eigen::VectorXd lambda;
  double step;
  Eigen::MatrixXd Q;  ///< n × N
  Eigen::MatrixXd M;  ///< n = N: the body momentum
  Eigen::MatrixXd S;  ///< n < N: Q̇Λ

  bool square() const { return Q.rows() == Q.cols(); }
};

/// A state in the blocks of a form, with the numbers that its scene needs in addition.
struct FormBlocks {
  std::map<std::string, Eigen::MatrixXd> blocks;
  std::optional<double> epsilon = {}, parameter = {};
};

using Margins = std::vector<Margin>;

/// Returns the refusal with the argument that is outside the domain: a field of the scene, "to",
/// "epsilon" or "parameter".
inline std::unexpected<OutsideDomain> outside(OutsideDomain refusal, std::string argument) {
  refusal.field = std::move(argument);
  return std::unexpected(std::move(refusal));
}

/// The maps between the blocks of a system and the phase, for SystemEntry::representation. A map is
/// null where there is none. A refusal names the argument (`outside`).
struct Representation {
  bool square;  ///< for n = N only
  WithinDomain<Phase> (*read)(const Scene&, Margins&);
  WithinDomain<FormBlocks> (*write)(const Phase&, const ConversionTarget&, Margins&);
  bool has_epsilon = false, has_parameter = false;  ///< whether `write` takes ε and μ of the target
};

namespace representations {
/// Those of `other_targets` (conversion.h), which are not systems.
extern const Representation velocity, angular_velocity, interpolation;
/// That of moser_veselov_pair: two consecutive frames Q_prev and Q, n = N.
extern const Representation moser_veselov_pair;
/// The name of the system of (Q, M), rigid_body.
extern const char* const body_system;
}  // namespace representations

/// Returns the phase of (Q, M), n = N.
inline Phase phase_of_body(const Scene& scene, Eigen::MatrixXd Q, Eigen::MatrixXd M) {
  return {scene.inertia(), scene.step(), std::move(Q), std::move(M), {}};
}

/// Adds the margin of the blocks as a representation of M ≠ 0: the relative error of M is that of
/// the blocks divided by this margin. M = 0 is exact.
inline void add_condition(const Eigen::MatrixXd& M, double inverse_condition, Margins& margins) {
  if (!M.isZero(0)) margins.push_back({"1/condition of M", inverse_condition});
}

}  // namespace stiefel
