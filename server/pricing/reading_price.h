#pragma once

#include <string_view>

#include "server/sessions/session.h"

namespace stiefel::server {

/// Returns the predicted instructions of reading a field, or the invariants of that name, from one
/// state of all members. 0 for a name that is neither.
double reading_work(const Session& session, std::string_view name);

/// Returns the kind of jobs for steps of the session with each of which so much work is done.
JobKind kind_with(const Session& session, double work);

}  // namespace stiefel::server
