#pragma once

#include <cstddef>
#include <vector>

#include "server/sessions/session.h"

namespace stiefel::server {

/// Whether a field is sent as binary32: a real field of a scene in single precision. All others are
/// sent as binary64.
bool is_float(const Session& session, const Field& field);

/// Returns the bytes of a field at one step.
std::size_t field_bytes(const Session& session, const Field& field);
/// Returns the bytes of the fields with these indices at one step.
std::size_t sample_bytes(const Session& session, const std::vector<std::size_t>& fields);

/// Returns the predicted instructions of computing a field of one state, by matrix products; 0 for
/// one that is reported by default: a block, which is copied, or a few numbers of a body.
double field_work(const Session& session, std::size_t index);
/// Returns those of a sample with these fields.
double sample_work(const Session& session, const std::vector<std::size_t>& fields);

/// Writes the field with this index at the simulation's step to `out`, which must be aligned for
/// its numbers: `field_bytes` bytes, little-endian and row by row.
void write_field(const Session& session, const Simulation& simulation, std::size_t index,
                 char* out);

}  // namespace stiefel::server
