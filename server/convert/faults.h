#pragma once

#include <concepts>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "server/convert/place.h"

namespace stiefel::server {

/// A path in a request, "forms[2].first.Q", which is written out only for a fault. It refers to its
/// name and to the path before it, which must outlive it.
class Path {
 public:
  Path(std::string_view name) : name_(name) {}    // NOLINT(google-explicit-constructor)
  Path(const char* name) : name_(name) {}         // NOLINT(google-explicit-constructor)
  Path(const std::string& name) : name_(name) {}  // NOLINT(google-explicit-constructor)
  Path(const Path& within, std::string_view field) : within_(&within), name_(field) {}
  Path(const Path& list, int index) : within_(&list), index_(index) {}

  std::string text() const {
    if (within_ == nullptr) return std::string(name_);
    const std::string before = within_->text();
    if (index_ >= 0) return before + "[" + std::to_string(index_) + "]";
    return before.empty() ? std::string(name_) : before + "." + std::string(name_);
  }

 private:
  const Path* within_ = nullptr;
  std::string_view name_;
  int index_ = -1;
};

/// What is wrong with a request: the first faults, and the number of the others.
struct FoundFaults {
  Violations violations;
  std::size_t more = 0;
};

/// Collects the faults of a request, each with its place: keeps the first `most` and counts the
/// others, so that a request with millions of faults costs neither memory nor time for their texts.
class Faults {
 public:
  static constexpr std::size_t most = 64;

  /// The place must outlive the faults.
  explicit Faults(const Place& place) : place_(place) {}

  bool empty() const { return found_.violations.empty(); }

  /// Adds the fault at `path` with the text of its value and rule: `text()` returns the two, and is
  /// called only for a fault that is kept.
  template <std::invocable Text>
  void add(const Path& path, Text text) {
    if (found_.violations.size() == most) return void(++found_.more);
    auto [value, rule] = text();
    found_.violations.push_back(place_.of({path.text(), std::move(value), std::move(rule)}));
  }
  void add(const Path& path, std::string value, std::string rule) {
    add(path, [&] { return std::pair(std::move(value), std::move(rule)); });
  }

  /// Adds a fault unless the value is at most `limit`; returns whether it is.
  bool at_most(const Path& path, std::integral auto value, std::integral auto limit) {
    if (std::cmp_less_equal(value, limit)) return true;
    add(path, std::to_string(value), "must be at most " + std::to_string(limit));
    return false;
  }

  FoundFaults take() { return std::move(found_); }

 private:
  const Place& place_;
  FoundFaults found_;
};

}  // namespace stiefel::server
