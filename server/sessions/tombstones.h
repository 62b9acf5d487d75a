#pragma once

#include <chrono>
#include <cstddef>
#include <list>
#include <string>
#include <string_view>
#include <unordered_map>

namespace stiefel::server {

/// The names of sessions that were deleted, each for a lifetime, so that nobody who still uses one
/// creates it again. When there are too many the oldest are dropped first. Not thread-safe.
class Tombstones {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::size_t max_count = std::size_t{1} << 16;
  /// Of the names and of what holds them, `entry_bytes` each.
  static constexpr std::size_t max_bytes = std::size_t{16} << 20;
  static constexpr std::size_t entry_bytes = 160;

  explicit Tombstones(std::chrono::milliseconds lifetime) : lifetime_(lifetime) {}

  /// The session of that name is deleted now; its lifetime starts again if it was before.
  void put(std::string name, Time now);
  /// Whether it was deleted less than a lifetime ago.
  bool contains(std::string_view name, Time now) const;
  void remove(std::string_view name);
  /// Drops what is older than the lifetime.
  void expire(Time now);
  std::size_t size() const { return order_.size(); }

 private:
  struct Entry {
    std::string name;
    Time deleted;
  };
  void drop(std::list<Entry>::iterator entry);

  const std::chrono::milliseconds lifetime_;
  std::list<Entry> order_;  // the oldest first
  std::unordered_map<std::string_view, std::list<Entry>::iterator> by_name_;
  std::size_t bytes_ = 0;
};

}  // namespace stiefel::server
