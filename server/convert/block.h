#pragma once

#include <string>

#include "stiefel/scene.h"
#include "stiefel/v1/scene.pb.h"

namespace stiefel::server {

/// What is wrong with a description, at its place in the request.
struct Faults {
  const Place& place;
  Violations violations = {};

  /// `field` is the description's own: "initial.Q.rows".
  void add(const std::string& field, std::string value, std::string rule) {
    violations.push_back(place.violation(field, std::move(value), std::move(rule)));
  }
};

/// A block of a description; unchanged, with faults at `path`, where numbers of values are not what
/// the shape says.
void read_block(const std::string& path, const v1::Matrix& matrix, Block& out, Faults& faults);
/// The same of a tensor (rows, cols) or (members, rows, cols), its blocks on top of each other.
void read_block(const std::string& path, const v1::Tensor& tensor, Block& out, Faults& faults);

void write_block(const Block& block, v1::Matrix* out);

}  // namespace stiefel::server
