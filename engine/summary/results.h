#pragma once

#include <span>
#include <vector>

#include "engine/summary/member_group.h"

namespace stiefel {

/// Returns the arrays of Summary::statistics from groups that are done, in the order of their
/// members.
std::vector<SummaryArray> results(const Plan& plan, std::span<const MemberGroup* const> groups,
                                  bool ensemble);

/// Returns how many bytes the numbers of these arrays take.
std::uint64_t result_bytes(const Plan& plan, std::size_t members);

}  // namespace stiefel
