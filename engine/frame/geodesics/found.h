#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>

#include "stiefel/connect.h"

namespace stiefel {

/// What the search for a geodesic found, at the time scale 1.
struct Found {
  Eigen::MatrixXd V;  ///< Q̇(0); empty where there is none to the residual `joined`
  Shortest shortest = Shortest::none_shorter_found;
  /// The number of different geodesics that were seen, and the index of the start that led to this
  /// one.
  int distinct = 0, start = 0;
  double residual = std::numeric_limits<double>::infinity();  ///< the best where V is empty
  std::optional<double> length = {};  ///< of V at Λ = I or β, where it is known
};

}  // namespace stiefel
