#pragma once

#include <cstddef>

#include "server/sessions/session.h"

namespace stiefel::server {

/// Whether a field's numbers are sent as binary32: those of a scene of single precision. Else they
/// are binary64.
bool is_float(const Session& session, const Field& field);

/// Bytes of a field at one step.
std::size_t field_bytes(const Session& session, const Field& field);

/// Writes a field at the simulation's step, little-endian and row by row: `field_bytes` bytes, at
/// an address that is aligned for its numbers.
void write_field(const Session& session, const Simulation& simulation, std::size_t index,
                 char* out);

}  // namespace stiefel::server
