#pragma once

#include "stiefel/tradeoff.h"

namespace stiefel {

/// Chooses a method for an ensemble (choose_method, tradeoff.h): one method with one number of
/// substeps, whose error stays within the tolerance in every member.
///
/// The choice is made for some members, the pilots, at first for the fastest member alone: it is
/// the cheapest method that keeps the tolerance in all pilots. The method is then measured on each
/// of the other members, the fastest first. Up to four members in which it misses the tolerance
/// become pilots, and the choice is repeated, up to eight times. The method that is returned has
/// thus been measured on every member. The whole search takes at most Choice::most_work; where that
/// does not suffice to measure every member, the choice is refused.
std::expected<Choice, Violations> choose_for_members(const SceneDescription& description,
                                                     const Place& place);

}  // namespace stiefel
