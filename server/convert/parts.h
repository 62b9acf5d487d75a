#pragma once

#include <cstdint>
#include <deque>

#include "stiefel/v1/tensor.pb.h"

namespace stiefel::server {

/// Arrays that are sent in messages of limited size.
class Parts {
 public:
  using Fields = google::protobuf::RepeatedPtrField<v1::Field>;

  void add(v1::Field whole) { fields_.push_back(std::move(whole)); }
  bool empty() const { return fields_.empty(); }
  /// Returns the bytes of the arrays that are left.
  std::size_t bytes() const;
  /// Moves about `budget` bytes to `out`: whole arrays, and at the end a part of one, which ends
  /// with a row if a row fits. Moves at least one element.
  void take(std::size_t budget, Fields* out);

 private:
  std::deque<v1::Field> fields_;
  std::size_t sent_ = 0;  ///< bytes of the first array that were taken
};

}  // namespace stiefel::server
