#pragma once

#include <map>
#include <vector>

#include "engine/representations/outside_domain.h"
#include "stiefel/conversion.h"

namespace stiefel {

/// A state in the variables through which every form is converted.
struct Phase {
  Eigen::VectorXd lambda;
  double step;
  Eigen::MatrixXd Q;  ///< n × N
  Eigen::MatrixXd M;  ///< n = N: the body momentum
  Eigen::MatrixXd S;  ///< n < N: Q̇Λ

  bool square() const { return Q.rows() == Q.cols(); }
};

/// A state in the blocks of some form, with the numbers that its scene needs beside them.
struct Expression {
  std::map<std::string, Eigen::MatrixXd> blocks;
  std::optional<double> epsilon = {}, parameter = {};
};

using Margins = std::vector<Margin>;

/// The maps between a form and the phase. Null where a form has none.
struct Representation {
  bool square;  ///< n = N alone
  WithinDomain<Phase> (*read)(const Scene&, Margins&);
  WithinDomain<Expression> (*write)(const Phase&, const ConversionTarget&, Margins&);
};

}  // namespace stiefel
