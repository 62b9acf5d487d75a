#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stiefel {

/// A fault of a request: the path of the field ("scene.initial.Q"), its value and the rule that it
/// breaks.
struct Violation {
  std::string field;
  std::string value;
  std::string rule;
  /// A constant in UPPER_SNAKE_CASE for faults that programs tell apart; `metadata` holds its
  /// numbers.
  std::string reason = {};
  std::map<std::string, std::string> metadata = {};
};
using Violations = std::vector<Violation>;

/// Maps the fields of a description to the fields of the request that the caller wrote. A check
/// names the description's field ("initial.Q"); the place gives the path that the caller can change
/// ("scene.initial.Q").
class Place {
 public:
  /// The description is the request itself: "initial.Q" stays "initial.Q".
  Place() = default;
  /// The description is the message at `path`: "initial.Q" becomes "scene.initial.Q" for the path
  /// "scene".
  static Place inside(std::string path) { return Place(std::move(path), true); }
  /// The description was computed from the field at `path`, which has no such subfields: every
  /// violation is at `path`, and its value begins with "initial.Q: ".
  static Place made_of(std::string path) { return Place(std::move(path), false); }

  /// Maps `field` ("method") and its subfields to `path` instead.
  Place& with(std::string field, std::string path) {
    elsewhere_[std::move(field)] = std::move(path);
    return *this;
  }

  /// Returns a violation of a field, or of the whole description when `field` is empty.
  Violation violation(std::string_view field, std::string value, std::string rule) const {
    const std::size_t end = std::min(field.find_first_of(".["), field.size());
    if (const auto found = elsewhere_.find(field.substr(0, end)); found != elsewhere_.end())
      return {found->second + std::string(field.substr(end)), std::move(value), std::move(rule)};
    if (path_.empty()) return {std::string(field), std::move(value), std::move(rule)};
    if (field.empty()) return {path_, std::move(value), std::move(rule)};
    if (message_) return {path_ + "." + std::string(field), std::move(value), std::move(rule)};
    return {path_, std::string(field) + ": " + value, std::move(rule)};
  }

 private:
  Place(std::string path, bool message) : path_(std::move(path)), message_(message) {}

  std::string path_;
  bool message_ = true;
  std::map<std::string, std::string, std::less<>> elsewhere_;
};

}  // namespace stiefel
