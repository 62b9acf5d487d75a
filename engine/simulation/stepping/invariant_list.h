#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <string_view>
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

  explicit InvariantList(std::span<const std::string> only) : only_(only) {}

  bool wants(std::string_view family, bool cheap = true) const {
    return only_.empty() ? cheap : std::ranges::any_of(only_, [&](std::string_view name) {
      return name.substr(0, name.find('[')) == family;
    });
  }

  void add(std::string_view family, std::string name, long double value, long double scale) {
    if (!std::isfinite(static_cast<double>(value)) || !std::isfinite(static_cast<double>(scale)))
      return;  // in these units it is no number
    if (only_.empty() || std::ranges::any_of(only_, [&](std::string_view asked) {
          return asked == family || asked == name;
        }))
      entries_.push_back({family, std::move(name), value, scale});
  }

  /// A family of one.
  void add(std::string_view family, long double value, long double scale) {
    add(family, std::string(family), value, scale);
  }

  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::span<const std::string> only_;
  std::vector<Entry> entries_;
};

}  // namespace stiefel
