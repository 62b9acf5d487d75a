#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace stiefel::testing {

/// A motion that was computed in 50-digit arithmetic, by extrapolation of the plain vector field to
/// 1e-34. Matrices are stored row by row.
struct ReferenceMotion {
  std::string name;
  int n = 0, N = 0;
  double t = 0;
  /// Λ; Q at time 0; S (n < N) or M (n = N) at time 0; Q at time t.
  std::vector<double> lambda, Q_0, momentum, Q;
  NLOHMANN_DEFINE_TYPE_INTRUSIVE(ReferenceMotion, name, n, N, t, lambda, Q_0, momentum, Q)
};

/// Reads reference_motions.json beside this header.
inline std::vector<ReferenceMotion> reference_motions() {
  std::ifstream in(std::filesystem::path(__FILE__).parent_path() / "reference_motions.json");
  return nlohmann::json::parse(in).get<std::vector<ReferenceMotion>>();
}

}  // namespace stiefel::testing
