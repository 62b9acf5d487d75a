#include "engine/stepping/invariant_list.h"

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

}  // namespace stiefel
