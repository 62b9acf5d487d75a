#include "tests/support/reference_cases.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace stiefel::testing {
namespace {

/// Reads a number, which the file holds as a decimal string, or a count, which it holds as a
/// number.
long double read(const nlohmann::json& entry) {
  return entry.is_string() ? std::stold(entry.get<std::string>()) : entry.get<long double>();
}

nlohmann::json file_beside(const char* name) {
  std::ifstream in(std::string(REFERENCE_CASES "/") + name);
  return nlohmann::json::parse(in);
}

}  // namespace

std::string ReferenceCase::name() const { return json_->at("name"); }

double ReferenceCase::number(const std::string& key) const {
  return static_cast<double>(read(json_->at(key)));
}

Vector<long double> ReferenceCase::wide_vector(const std::string& key) const {
  const auto& list = json_->at(key);
  Vector<long double> v(static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) v(static_cast<Eigen::Index>(i)) = read(list[i]);
  return v;
}

Matrix<long double> ReferenceCase::wide_matrix(const std::string& key, const char* part) const {
  const auto& rows = part ? json_->at(key).at(part) : json_->at(key);
  Matrix<long double> A(rows.size(), rows.at(0).size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < rows[i].size(); ++j)
      A(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = read(rows[i][j]);
  return A;
}

std::vector<ReferenceCase> reference_cases(const std::string& system) {
  std::vector<ReferenceCase> cases;
  const nlohmann::json file = file_beside("reference.json");
  for (const auto& entry : file.at("cases"))
    if (entry.at("system") == system)
      cases.emplace_back(std::make_shared<const nlohmann::json>(entry));
  if (cases.empty()) throw std::runtime_error("no reference case of " + system);
  return cases;
}

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ReferenceMotion, name, n, N, t, lambda, Q_0, momentum, Q)

std::vector<ReferenceMotion> reference_motions() {
  return file_beside("reference_motions.json").get<std::vector<ReferenceMotion>>();
}

}  // namespace stiefel::testing
