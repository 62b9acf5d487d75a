#pragma once

#include <gtest/gtest.h>

#include "stiefel/client/error.h"

namespace stiefel::client {

/// Returns the Error that the call throws.
template <class Call>
Error error_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no Error was thrown";
  return Error(grpc::Status::OK);
}

}  // namespace stiefel::client
