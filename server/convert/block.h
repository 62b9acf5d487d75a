#pragma once

#include <optional>

#include "server/convert/checks/faults.h"
#include "stiefel/scene.h"
#include "stiefel/v1/scene.pb.h"

namespace stiefel::server {

/// Reads a block of a description. If the numbers of values do not match the shape, leaves `out`
/// unchanged and adds faults at `path`.
void read_block(const Path& path, const v1::Matrix& matrix, Block& out, Faults& faults);
/// Reads a block from a tensor of shape (rows, cols) or (members, rows, cols), with the members'
/// blocks stacked. Adds faults as for a matrix.
void read_block(const Path& path, const v1::Tensor& tensor, Block& out, Faults& faults);

/// Reads a single matrix, which must be finite. Returns nothing and adds faults if it is refused.
std::optional<Block> read_matrix(const Path& path, const v1::Matrix& matrix, Faults& faults);

void write_block(const Block& block, v1::Matrix* out);

}  // namespace stiefel::server
