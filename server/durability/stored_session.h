#pragma once

#include <expected>
#include <memory>
#include <string>

#include "server/sessions/session.h"
#include "server/store/store.h"

namespace stiefel::server {

/// Returns a session as a row, with the resolved scene as a stiefel.v1.Scene, which keeps every
/// bit.
StoredSession to_row(const Session& session);

using Restored = std::expected<std::shared_ptr<Session>, std::string>;

/// Returns the session of a row, with the state of its checkpoint in its cache; or why this build
/// cannot restore it. A row with the same numerics id gives the stored scene, bit for bit.
Restored from_row(const Store::Row& row, std::shared_ptr<const Clock> clock,
                  std::shared_ptr<const CheckpointKeys> keys = nullptr,
                  MemoryBudget& memory = MemoryBudget::unlimited());

}  // namespace stiefel::server
