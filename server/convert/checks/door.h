#pragma once

#include "stiefel/v1/outcome.pb.h"
#include "stiefel/v1/tensor.pb.h"

/// The last look at a reply: none says OUTCOME_REACHED and carries a number that is not finite.
namespace stiefel::server {

/// Whether all numbers of the tensor are finite.
bool is_finite(const v1::Tensor& tensor);
bool is_finite(const google::protobuf::RepeatedPtrField<v1::Field>& fields);
/// Whether all numbers of the message's tensors are finite, and no other number of it is NaN.
bool is_finite(const google::protobuf::Message& message);

/// Changes OUTCOME_REACHED to OUTCOME_NOT_FINITE unless `finite`.
void check_at_the_door(bool finite, v1::RunStatus* status);

}  // namespace stiefel::server
