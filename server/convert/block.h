#pragma once

#include <string>

#include "stiefel/scene.h"
#include "stiefel/v1/scene.pb.h"

namespace stiefel::server {

/// Collects the faults of a description, each with its place in the request.
struct Faults {
  const Place& place;
  Violations violations = {};

  /// `field` is a path within the description, such as "initial.Q.rows".
  void add(const std::string& field, std::string value, std::string rule) {
    violations.push_back(place.violation(field, std::move(value), std::move(rule)));
  }
};

/// Reads a block of a description. If the numbers of values do not match the shape, leaves `out`
/// unchanged and adds faults at `path`.
void read_block(const std::string& path, const v1::Matrix& matrix, Block& out, Faults& faults);
/// Reads a block from a tensor of shape (rows, cols) or (members, rows, cols), with the members'
/// blocks stacked. Adds faults as for a matrix.
void read_block(const std::string& path, const v1::Tensor& tensor, Block& out, Faults& faults);

void write_block(const Block& block, v1::Matrix* out);

}  // namespace stiefel::server
