#pragma once

#include <boost/property_tree/json_parser.hpp>
#include <boost/property_tree/ptree.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/linalg/scalar.h"

namespace stiefel::testing {

/// A case of reference.json, which says what stands in it: numbers of 20 digits as text.
class ReferenceCase {
 public:
  explicit ReferenceCase(boost::property_tree::ptree tree) : tree_(std::move(tree)) {}

  std::string name() const { return tree_.get<std::string>("name"); }
  long double number(const std::string& key) const {
    return std::stold(tree_.get<std::string>(key));
  }
  Vector<long double> vector(const std::string& key) const { return row(tree_.get_child(key)); }
  Matrix<long double> matrix(const std::string& key) const {
    const auto& rows = tree_.get_child(key);
    Matrix<long double> A(rows.size(), rows.front().second.size());
    Eigen::Index i = 0;
    for (const auto& [unused, numbers] : rows) A.row(i++) = row(numbers);
    return A;
  }

 private:
  static Vector<long double> row(const boost::property_tree::ptree& numbers) {
    Vector<long double> v(numbers.size());
    Eigen::Index i = 0;
    for (const auto& [unused, number] : numbers) v(i++) = std::stold(number.data());
    return v;
  }

  boost::property_tree::ptree tree_;
};

inline std::vector<ReferenceCase> reference_cases(const std::string& system) {
  boost::property_tree::ptree tree;
  read_json((std::filesystem::path(__FILE__).parent_path() / "reference.json").string(), tree);
  std::vector<ReferenceCase> cases;
  for (const auto& [unused, one] : tree.get_child("cases"))
    if (one.get<std::string>("system") == system) cases.emplace_back(one);
  return cases;
}

}  // namespace stiefel::testing
