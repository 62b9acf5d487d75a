#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/numbers/scalar.h"

namespace stiefel::testing {

/// A solution with 20 digits, read from reference.json beside this header. It was computed in
/// 50-digit arithmetic with methods that the engine does not have: Gragg–Bulirsch–Stoer for flows,
/// the map itself for maps.
class ReferenceCase {
 public:
  explicit ReferenceCase(std::shared_ptr<const nlohmann::json> json) : json_(std::move(json)) {}

  std::string name() const;
  double number(const std::string& key) const;

  template <class Scalar = double>
  Vector<Scalar> vector(const std::string& key) const {
    return wide_vector(key).cast<Scalar>();
  }
  /// Returns a real matrix, or the part "re" or "im" of a complex one.
  template <class Scalar = double>
  Matrix<Scalar> matrix(const std::string& key, const char* part = nullptr) const {
    return wide_matrix(key, part).cast<Scalar>();
  }

 private:
  Vector<long double> wide_vector(const std::string& key) const;
  Matrix<long double> wide_matrix(const std::string& key, const char* part) const;

  std::shared_ptr<const nlohmann::json> json_;
};

/// Returns the cases of one system. Throws when there is none, so that no test passes without
/// numbers.
std::vector<ReferenceCase> reference_cases(const std::string& system);

/// A motion that was computed in 50-digit arithmetic, by extrapolation of the plain vector field to
/// 1e-34. Matrices are stored row by row.
struct ReferenceMotion {
  std::string name;
  int n = 0, N = 0;
  double t = 0;
  /// Λ; Q at time 0; S (n < N) or M (n = N) at time 0; Q at time t.
  std::vector<double> lambda, Q_0, momentum, Q;
};

/// Reads reference_motions.json beside this header.
std::vector<ReferenceMotion> reference_motions();

}  // namespace stiefel::testing
