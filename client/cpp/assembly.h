#pragma once

#include "stiefel/v1/tensor.pb.h"

namespace stiefel::client {

using Fields = google::protobuf::RepeatedPtrField<v1::Field>;

/// Throws CorruptReply if a whole array has an unknown data type, or other than the bytes that its
/// shape says.
void check_complete(const v1::Field& array);

/// Joins the parts of arrays that travel in several messages.
class Assembly {
 public:
  /// Takes arrays, whole or in part, in the order in which they arrived. Throws CorruptReply if a
  /// part does not continue the part before it.
  void take(Fields* arrays);
  void take(v1::Field* array);

  /// Returns the whole arrays and leaves this object empty. Throws CorruptReply if an array is
  /// incomplete.
  Fields finish();
  /// Whether something was taken since the last `finish`.
  bool begun() const { return !arrays_.empty(); }

 private:
  Fields arrays_;
};

}  // namespace stiefel::client
