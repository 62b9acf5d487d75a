#include "server/sessions/tombstones.h"

#include <iterator>
#include <utility>

namespace stiefel::server {

void Tombstones::put(std::string name, Time now) {
  remove(name);
  expire(now);
  bytes_ += name.size() + entry_bytes;
  order_.push_back({std::move(name), now});
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
  bytes_ -= entry->name.size() + entry_bytes;
  by_name_.erase(entry->name);
  order_.erase(entry);
}

}  // namespace stiefel::server
