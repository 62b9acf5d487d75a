#pragma once

#include "server/convert/resolve.h"
#include "server/sessions/cursor.h"
#include "stiefel/v1/session.pb.h"

namespace stiefel::server {

/// Where violations of what a fork does not change are: at the session that it comes from.
Place inherited();

/// The scene that starts where the cursor is, with what the request changes. It is resolved; its
/// difference is from the scene of `from`.
OrStatus<ResolvedScene> forked(const Session& from, const Cursor& cursor,
                               const v1::ForkSessionRequest& request);

}  // namespace stiefel::server
