#include "server/sessions/checkpoints/checkpoints.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace stiefel::server {

void Checkpoints::put(std::int64_t step, Saved saved) {
  if (!wants(step)) return;
  saved_.emplace(step, State{std::move(saved)});
  thin();
}

void Checkpoints::restore(std::int64_t step, Saved saved, bool pinned) {
  if (step == 0) return;
  State& state = saved_.try_emplace(step, std::move(saved)).first->second;
  const bool is_new = !std::exchange(state.restored, true);
  state.pinned |= pinned;
  if (!is_new) return;
  std::vector<std::int64_t> restored;
  for (const auto& [at, one] : saved_)
    if (one.restored) restored.push_back(at);
  if (restored.size() > 2) release(restored[step == restored[1] ? 2 : 1]);
  thin();
}

void Checkpoints::release(std::int64_t step) {
  const auto found = saved_.find(step);
  found->second.restored = found->second.pinned = false;
  if (step % spacing_ != 0) saved_.erase(found);
}

bool Checkpoints::fits() const {
  std::size_t bytes = 0;
  for (const auto& [step, state] : saved_) bytes += state.saved->size() * sizeof(double);
  return saved_.size() <= max_count && bytes <= max_bytes;
}

void Checkpoints::thin() {
  const auto is_computed = [](const auto& one) { return one.first != 0 && !one.second.restored; };
  const auto is_restored = [](const auto& one) { return one.second.restored; };
  while (!fits()) {
    if (std::ranges::any_of(saved_, is_computed)) {
      spacing_ *= 2;
      std::erase_if(saved_,
                    [&](const auto& one) { return is_computed(one) && one.first % spacing_ != 0; });
    } else if (std::ranges::count_if(saved_, is_restored) == 2) {
      release(std::ranges::find_if(saved_, is_restored)->first);
    } else {
      return;
    }
  }
}

Checkpoints::Nearest Checkpoints::nearest(std::int64_t step) const {
  const auto after = saved_.upper_bound(step);
  if (after == saved_.begin()) return {0, nullptr};
  const auto found = std::prev(after);
  return {found->first, found->second.saved};
}

std::vector<std::int64_t> Checkpoints::steps() const {
  std::vector<std::int64_t> steps;
  for (const auto& [step, state] : saved_) steps.push_back(step);
  return steps;
}

std::size_t Checkpoints::evictable() const {
  return static_cast<std::size_t>(std::ranges::count_if(saved_, is_evictable));
}

void Checkpoints::evict() { std::erase_if(saved_, is_evictable); }

}  // namespace stiefel::server
