#pragma once

#include <cmath>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

namespace stiefel {

/// "manakov[3,1]".
inline std::string indexed(std::string_view family, long i) {
  return std::string(family) + "[" + std::to_string(i) + "]";
}
inline std::string indexed(std::string_view family, long i, long j) {
  return std::string(family) + "[" + std::to_string(i) + "," + std::to_string(j) + "]";
}

/// The values of a state's invariants, those that are asked for: families ("manakov") or single
/// ones ("manakov[3,1]"); when none is named every family that is cheap.
class InvariantList {
 public:
  struct Entry {
    std::string_view family;
    std::string name;
    long double value;  ///< the powers in it need not fit into a double
    long double scale;  ///< what a change of the value is measured against
  };

  /// The names of `only` must outlive the list. Asked to stop, it is left incomplete.
  explicit InvariantList(std::span<const std::string> only, std::stop_token stop = {})
      : only_(only.begin(), only.end()), stop_(std::move(stop)) {
    for (const std::string_view name : only_) families_.insert(name.substr(0, name.find('[')));
  }

  /// The token that long sums look at.
  const std::stop_token& stop() const { return stop_; }

  bool wants(std::string_view family, bool cheap = true) const {
    return only_.empty() ? cheap : families_.contains(family);
  }

  void add(std::string_view family, std::string name, long double value, long double scale) {
    if (!std::isfinite(static_cast<double>(value)) || !std::isfinite(static_cast<double>(scale)))
      return;  // in these units it is no number
    if (only_.empty() || only_.contains(family) || only_.contains(name))
      entries_.push_back({family, std::move(name), value, scale});
  }

  /// A family of one.
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
