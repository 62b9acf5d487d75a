#include "engine/motion/flat_bodies.h"

#include <algorithm>
#include <stdexcept>

#include "engine/motion/system_entry.h"
#include "engine/numbers/parallel.h"
#include "stiefel/stop.h"

namespace stiefel {

bool FlatBodies::can_be_packed(std::size_t member) const {
  return packable_.size() == size_ || std::ranges::binary_search(packable_, member);
}

void FlatBodies::pack_all(std::vector<std::size_t> packable, int lanes) {
  constexpr double of_pack = 2000;  // nanoseconds
  packable_ = std::move(packable);
  lanes_ = lanes;
  const auto width = static_cast<std::size_t>(lanes);
  packs_.resize((packable_.size() + width - 1) / width);
  for_each_in_parallel(std::span(packs_), of_pack * static_cast<double>(packs_.size()),
                       [&](auto& pack) {
                         stop_point();
                         const auto p = static_cast<std::size_t>(&pack - packs_.data());
                         const std::size_t count = std::min(width, packable_.size() - width * p);
                         pack = make_pack(std::span(packable_).subspan(width * p, count));
                       });
}

std::shared_ptr<const PackedBodies> FlatBodies::pack(std::span<const std::size_t> members) const {
  const auto at = std::ranges::lower_bound(packable_, members.front());
  const auto first = static_cast<std::size_t>(at - packable_.begin());
  const auto width = static_cast<std::size_t>(lanes_);
  const auto theirs = std::span(packable_).subspan(first);
  if (first % width == 0 &&
      std::ranges::equal(members, theirs.first(std::min(width, theirs.size()))))
    return packs_[first / width];
  return make_pack(members);
}

std::shared_ptr<const FlatBodies> flat_bodies(const Scene& ensemble) {
  return has_flat_bodies(ensemble) ? system_entry(ensemble.system())->packs->flat(ensemble)
                                   : nullptr;
}
bool has_flat_bodies(const Scene& ensemble) {
  const Packs* packs = system_entry(ensemble.system())->packs;
  return !ensemble.members().empty() && packs && packs->is_flat(ensemble);
}

RunStatus FlatReader::advance(std::int64_t, const std::stop_token&) {
  throw std::logic_error("a reader does not advance");
}
void FlatReader::restore(std::int64_t, std::span<const double>) {
  throw std::logic_error("a reader has no state of its own");
}

}  // namespace stiefel
