#include "server/sessions/checkpoints/checkpoints.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace stiefel::server {
namespace {

std::size_t bytes(const Saved& saved) { return saved->size() * sizeof(double); }

}  // namespace

void Checkpoints::put(std::int64_t step, Saved saved) {
  if (!wants(step)) return;
  bytes_ += bytes(saved);
  saved_.emplace(step, std::move(saved));
  thin();
}

void Checkpoints::adopt(std::int64_t step, Saved saved) {
  if (saved_.contains(step)) return;
  const auto before = std::exchange(adopted_, step);
  bytes_ += bytes(saved);
  saved_.emplace(step, std::move(saved));
  if (before && *before > step && *before % spacing_ != 0) {
    const auto old = saved_.find(*before);
    bytes_ -= bytes(old->second);
    saved_.erase(old);
  }
  thin();
}

void Checkpoints::thin() {
  while (saved_.size() > max_count || bytes_ > max_bytes) {
    const std::size_t fixed = adopted_ ? 2 : 1;
    if (saved_.size() <= fixed) return;
    spacing_ *= 2;
    std::erase_if(saved_, [this](const auto& entry) {
      const bool drop = entry.first % spacing_ != 0 && entry.first != adopted_;
      if (drop) bytes_ -= bytes(entry.second);
      return drop;
    });
  }
}

Checkpoints::Nearest Checkpoints::nearest(std::int64_t step) const {
  const auto after = saved_.upper_bound(step);
  if (after == saved_.begin()) return {0, nullptr};
  const auto found = std::prev(after);
  return {found->first, found->second};
}

std::size_t Checkpoints::computed() const {
  const std::size_t fixed = saved_.contains(0) + (adopted_ && *adopted_ != 0);
  return saved_.size() - std::min(saved_.size(), fixed);
}

void Checkpoints::shed() {
  std::erase_if(saved_, [this](const auto& entry) {
    const bool drop = entry.first != 0 && entry.first != adopted_;
    if (drop) bytes_ -= bytes(entry.second);
    return drop;
  });
}

std::vector<std::int64_t> Checkpoints::steps() const {
  std::vector<std::int64_t> steps;
  for (const auto& [step, saved] : saved_) steps.push_back(step);
  return steps;
}

}  // namespace stiefel::server
