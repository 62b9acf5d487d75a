#include "server/sessions/tombstones.h"

#include <iterator>
#include <utility>

namespace stiefel::server {

MemoryLease Tombstones::lease(std::string_view name, MemoryBudget& memory) {
  try {
    return {memory, bytes(name)};
  } catch (const MemoryExhausted&) {
    return {};
  }
}

void Tombstones::put(std::string name, Time now, MemoryLease memory) {
  remove(name);
  expire(now);
  const std::size_t before = bytes_, taken = bytes(name);
  while (!memory && !order_.empty() && bytes_ + taken > before) drop(order_.begin());
  bytes_ += taken;
  order_.push_back({std::move(name), now, std::move(memory)});
  by_name_.emplace(order_.back().name, std::prev(order_.end()));
  while (order_.size() > max_count || bytes_ > max_bytes) drop(order_.begin());
}

bool Tombstones::contains(std::string_view name, Time now) const {
  const auto found = by_name_.find(name);
  return found != by_name_.end() && now - found->second->deleted < lifetime_;
}

void Tombstones::remove(std::string_view name) {
  if (const auto found = by_name_.find(name); found != by_name_.end()) drop(found->second);
}

void Tombstones::expire(Time now) {
  while (!order_.empty() && now - order_.front().deleted >= lifetime_) drop(order_.begin());
}

void Tombstones::drop(std::list<Entry>::iterator entry) {
  bytes_ -= bytes(entry->name);
  by_name_.erase(entry->name);
  order_.erase(entry);
}

}  // namespace stiefel::server
