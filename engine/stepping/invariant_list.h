#pragma once

#include <cmath>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

namespace stiefel {

/// Returns the name of one invariant of a family: "casimirs[1]", "manakov[3,1]".
inline std::string indexed(std::string_view family, long i) {
  return std::string(family) + "[" + std::to_string(i) + "]";
}
inline std::string indexed(std::string_view family, long i, long j) {
  return std::string(family) + "[" + std::to_string(i) + "," + std::to_string(j) + "]";
}

/// Collects the values of a state's invariants that are asked for: families ("manakov") or single
/// ones ("manakov[3,1]"). When none is named it collects every family that is cheap.
class InvariantList {
 public:
  struct Entry {
    std::string_view family;
    std::string name;
    long double value;  ///< long double, because powers may not fit into a double
    long double scale;  ///< the number by which a change of the value is divided
  };

  /// The names of `only` must outlive the list. A stop request leaves the list incomplete.
  explicit InvariantList(std::span<const std::string> only, std::stop_token stop = {})
      : only_(only.begin(), only.end()), stop_(std::move(stop)) {
    for (const std::string_view name : only_) families_.insert(name.substr(0, name.find('[')));
  }

  /// Returns the token that long sums check.
  const std::stop_token& stop() const { return stop_; }

  bool wants(std::string_view family, bool cheap = true) const {
    return only_.empty() ? cheap : families_.contains(family);
  }

  void add(std::string_view family, std::string name, long double value, long double scale) {
    if (!std::isfinite(static_cast<double>(value)) || !std::isfinite(static_cast<double>(scale)))
      return;  // the value overflows in the scene's units
    if (only_.empty() || only_.contains(family) || only_.contains(name))
      entries_.push_back({family, std::move(name), value, scale});
  }

  /// Adds a family that has a single invariant.
  void add(std::string_view family, long double value, long double scale) {
    add(family, std::string(family), value, scale);
  }

  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::unordered_set<std::string_view> only_, families_;
  std::stop_token stop_;
  std::vector<Entry> entries_;
};

}  // namespace stiefel
