#pragma once

#include "server/convert/resolve.h"
#include "server/sessions/cursor.h"
#include "stiefel/v1/session.pb.h"

namespace stiefel::server {

/// Returns the resolved scene that starts at the cursor's state, with the changes of the request.
/// Its difference is relative to the scene of `from`.
OrStatus<ResolvedScene> forked(const Session& from, const Cursor& cursor,
                               const v1::ForkSessionRequest& request);

}  // namespace stiefel::server
