#pragma once

#include <expected>
#include <memory>
#include <string>

#include "server/sessions/session.h"
#include "server/store/store.h"

namespace stiefel::server {

/// A session as a row: the resolved scene as a stiefel.v1.Scene, which keeps every bit.
StoredSession to_row(const Session& session);

using Restored = std::expected<std::shared_ptr<Session>, std::string>;

/// The session of a row, with the state of its checkpoint in its cache; or why this build has none
/// for it. A row of the same numerics id gives the scene that was stored, bit for bit.
Restored from_row(const Store::Row& row, std::shared_ptr<const Clock> clock,
                  std::shared_ptr<const CheckpointKeys> keys = nullptr,
                  MemoryBudget& memory = MemoryBudget::unlimited());

}  // namespace stiefel::server
