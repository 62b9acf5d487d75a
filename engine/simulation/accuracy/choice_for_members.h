#pragma once

#include "stiefel/tradeoff.h"

namespace stiefel {

/// choose_method for an ensemble: one method, with one number of substeps, whose error stays within
/// the tolerance in every member.
///
/// The choice is made for some members, the pilots, at first for the fastest one alone: the method
/// is the cheapest that keeps the tolerance in all of them. It is then measured on each of the
/// other members, the fastest first. Up to four in which it misses the tolerance become pilots, and
/// the choice is made anew, up to eight times. So every member has been measured with the method
/// that is returned. All of it takes at most Choice::most_work; where that does not pay for
/// measuring every member, the choice is refused.
std::expected<Choice, Violations> choose_for_members(const SceneDescription& description,
                                                     const Place& place);

}  // namespace stiefel
