#include "engine/motion/invariant_list.h"

#include <algorithm>
#include <cmath>

namespace stiefel {

std::string indexed(std::string_view family, long i) {
  return std::string(family).append("[").append(std::to_string(i)).append("]");
}

std::string indexed(std::string_view family, long i, long j) {
  std::string name(family);
  name.append("[").append(std::to_string(i)).append(",").append(std::to_string(j));
  return name.append("]");
}

InvariantList::InvariantList(std::span<const std::string> only, std::stop_token stop)
    : only_(only.begin(), only.end()), stop_(std::move(stop)) {
  for (const std::string_view name : only_) families_.insert(name.substr(0, name.find('[')));
}

bool InvariantList::wants(std::string_view family, bool cheap) const {
  return only_.empty() ? cheap : families_.contains(family);
}

void InvariantList::add(std::string_view family, std::string name, long double value,
                        long double scale) {
  if (!std::isfinite(static_cast<double>(value)) || !std::isfinite(static_cast<double>(scale)))
    return;
  if (only_.empty() || only_.contains(family) || only_.contains(name))
    entries_.push_back({family, std::move(name), value, scale});
}

void InvariantList::add(std::string_view family, long double value, long double scale) {
  add(family, std::string(family), value, scale);
}

void InvariantList::add_coefficients(std::string_view family,
                                     const std::vector<std::vector<long double>>& coefficients,
                                     bool laurent) {
  for (std::size_t k = 1; k <= coefficients.size(); ++k) {
    long double size = 0;
    for (const long double c : coefficients[k - 1]) size = std::max(size, std::abs(c));
    for (std::size_t j = 0; j < coefficients[k - 1].size(); ++j) {
      const auto power = static_cast<long>(j) - (laurent ? static_cast<long>(k) : 0);
      add(family, indexed(family, static_cast<long>(k), power), coefficients[k - 1][j], size);
    }
  }
}

}  // namespace stiefel
