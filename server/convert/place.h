#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "stiefel/violation.h"

namespace stiefel::server {

/// Maps the fields of a description to the fields of the request that the caller wrote. The engine
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

  /// Returns the violation of a field, or of the whole description when `field` is empty, at its
  /// place in the request.
  Violation of(Violation one) const {
    const std::size_t end = std::min(one.field.find_first_of(".["), one.field.size());
    const auto found = elsewhere_.find(std::string_view(one.field).substr(0, end));
    if (found != elsewhere_.end()) {
      one.field.replace(0, end, found->second);
    } else if (!path_.empty() && one.field.empty()) {
      one.field = path_;
    } else if (!path_.empty() && message_) {
      one.field.insert(0, path_ + ".");
    } else if (!path_.empty()) {
      one.value.insert(0, one.field + ": ");
      one.field = path_;
    }
    return one;
  }
  Violations of(Violations all) const {
    for (Violation& one : all) one = of(std::move(one));
    return all;
  }

 private:
  Place(std::string path, bool message) : path_(std::move(path)), message_(message) {}

  std::string path_;
  bool message_ = true;
  std::map<std::string, std::string, std::less<>> elsewhere_;
};

/// The place of faults in the request itself.
inline const Place in_the_request;

}  // namespace stiefel::server
