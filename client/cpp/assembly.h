#pragma once

#include "stiefel/v1/tensor.pb.h"

namespace stiefel::client {

using Fields = google::protobuf::RepeatedPtrField<v1::Field>;

/// Puts arrays that travel in parts together.
class Assembly {
 public:
  /// Takes arrays, whole or in part, in the order in which they came. Throws CorruptReply where a
  /// part does not follow the one before.
  void take(Fields* arrays);
  void take(v1::Field* array);

  /// Hands the arrays out, each whole, and begins anew. Throws CorruptReply if one is incomplete.
  Fields finish();

 private:
  Fields arrays_;
};

}  // namespace stiefel::client
