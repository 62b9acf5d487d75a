#pragma once

#include <chrono>
#include <cstddef>
#include <list>
#include <string>
#include <string_view>
#include <unordered_map>

#include "server/limits/memory_budget.h"

namespace stiefel::server {

/// Keeps the names of deleted sessions, each for a lifetime, so that no client that still uses a
/// name creates its session again. Drops the oldest names when there are too many. Not thread-safe.
class Tombstones {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::size_t max_count = std::size_t{1} << 16;
  /// The most bytes of all entries; an entry counts its name and `entry_bytes`.
  static constexpr std::size_t max_bytes = std::size_t{16} << 20;
  static constexpr std::size_t entry_bytes = 160;

  explicit Tombstones(std::chrono::milliseconds lifetime) : lifetime_(lifetime) {}

  /// Returns the bytes of an entry.
  static std::size_t bytes(std::string_view name) { return name.size() + entry_bytes; }
  /// Returns a lease of these bytes, without a budget if they do not fit. Gives up caches.
  static MemoryLease lease(std::string_view name, MemoryBudget& memory);

  /// Records that the session `name` is deleted now; restarts the lifetime of a name that is there.
  /// `memory` is the lease of the entry. If that has no budget, drops as many bytes of the oldest
  /// entries as the new one takes.
  void put(std::string name, Time now,
           MemoryLease memory = MemoryLease(MemoryBudget::unlimited(), 0));
  /// Whether the session `name` was deleted less than a lifetime ago.
  bool contains(std::string_view name, Time now) const;
  void remove(std::string_view name);
  /// Drops the names that are older than the lifetime.
  void expire(Time now);
  std::size_t size() const { return order_.size(); }

 private:
  struct Entry {
    std::string name;
    Time deleted;
    MemoryLease memory;
  };
  void drop(std::list<Entry>::iterator entry);

  const std::chrono::milliseconds lifetime_;
  std::list<Entry> order_;  // the oldest first
  std::unordered_map<std::string_view, std::list<Entry>::iterator> by_name_;
  std::size_t bytes_ = 0;
};

}  // namespace stiefel::server
