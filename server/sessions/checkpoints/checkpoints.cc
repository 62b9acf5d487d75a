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

void Checkpoints::adopt(std::int64_t step, Saved saved, bool lasting) {
  if (step == 0) return;
  if (const auto known = std::ranges::find(adopted_, step, &Adopted::step);
      known != adopted_.end()) {
    known->lasting |= lasting;
    return;
  }
  if (!saved_.contains(step)) {
    bytes_ += bytes(saved);
    saved_.emplace(step, std::move(saved));
  }
  adopted_.insert(std::ranges::upper_bound(adopted_, step, {}, &Adopted::step), {step, lasting});
  if (adopted_.size() > 2) drop_adopted(step == adopted_[1].step ? 2 : 1);
  thin();
}

void Checkpoints::drop_adopted(std::size_t index) {
  const auto one = adopted_.begin() + static_cast<std::ptrdiff_t>(index);
  const std::int64_t step = one->step;
  adopted_.erase(one);
  drop_if([&](std::int64_t kept) { return kept == step && step % spacing_ != 0; });
}

template <class Drop>
void Checkpoints::drop_if(Drop drop) {
  std::erase_if(saved_, [&](const auto& entry) {
    const bool drops = drop(entry.first);
    if (drops) bytes_ -= bytes(entry.second);
    return drops;
  });
}

void Checkpoints::thin() {
  while (saved_.size() > max_count || bytes_ > max_bytes) {
    if (computed() > 0) {
      spacing_ *= 2;
      drop_if([&](std::int64_t step) { return step % spacing_ != 0 && !is_adopted(step); });
    } else if (adopted_.size() == 2) {
      drop_adopted(0);
    } else {
      return;
    }
  }
}

Checkpoints::Nearest Checkpoints::nearest(std::int64_t step) const {
  const auto after = saved_.upper_bound(step);
  if (after == saved_.begin()) return {0, nullptr};
  const auto found = std::prev(after);
  return {found->first, found->second};
}

std::size_t Checkpoints::computed() const {
  return saved_.size() - saved_.contains(0) - adopted_.size();
}

void Checkpoints::evict() {
  std::erase_if(adopted_, [](const Adopted& one) { return !one.lasting; });
  drop_if([&](std::int64_t step) { return step != 0 && !is_adopted(step); });
}

}  // namespace stiefel::server
