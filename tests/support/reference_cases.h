#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/numbers/scalar.h"

namespace stiefel::testing {

/// A solution with 20 digits, read from reference.json beside this header. It was computed in
/// 50-digit arithmetic with methods that the engine does not have: Gragg–Bulirsch–Stoer for flows,
/// the map itself for maps.
class ReferenceCase {
 public:
  explicit ReferenceCase(nlohmann::json json) : json_(std::move(json)) {}

  std::string name() const { return json_.at("name"); }
  double number(const std::string& key) const { return static_cast<double>(read(json_.at(key))); }

  template <class Scalar = double>
  Vector<Scalar> vector(const std::string& key) const {
    const auto& list = json_.at(key);
    Vector<Scalar> v(static_cast<Eigen::Index>(list.size()));
    for (std::size_t i = 0; i < list.size(); ++i)
      v(static_cast<Eigen::Index>(i)) = static_cast<Scalar>(read(list[i]));
    return v;
  }
  /// Returns a real matrix, or the part "re" or "im" of a complex one.
  template <class Scalar = double>
  Matrix<Scalar> matrix(const std::string& key, const char* part = nullptr) const {
    const auto& rows = part ? json_.at(key).at(part) : json_.at(key);
    Matrix<Scalar> A(rows.size(), rows.at(0).size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t j = 0; j < rows[i].size(); ++j)
        A(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            static_cast<Scalar>(read(rows[i][j]));
    return A;
  }

 private:
  /// Reads a number, which the file holds as a decimal string, or a count, which it holds as a
  /// number.
  static long double read(const nlohmann::json& entry) {
    return entry.is_string() ? std::stold(entry.get<std::string>()) : entry.get<long double>();
  }

  nlohmann::json json_;
};

/// Returns the cases of one system. Throws when there is none, so that no test passes without
/// numbers.
inline std::vector<ReferenceCase> reference_cases(const std::string& system) {
  std::ifstream in(std::filesystem::path(__FILE__).parent_path() / "reference.json");
  std::vector<ReferenceCase> cases;
  const auto json = nlohmann::json::parse(in);
  for (const auto& entry : json.at("cases"))
    if (entry.at("system") == system) cases.emplace_back(entry);
  if (cases.empty()) throw std::runtime_error("no reference case of " + system);
  return cases;
}

}  // namespace stiefel::testing
