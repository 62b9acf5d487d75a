#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/server/harness.h"

namespace stiefel::test {

/// What a caller gets of one call: the samples and numbers, as text or bytes, and the end.
struct Heard {
  std::string call;
  std::string said;
  grpc::Status status;
};

/// Makes the calls of every_call.txtpb, and longer ones of small and large sessions: the same calls
/// every time, which leave no session.
std::vector<Heard> call_all(const std::shared_ptr<grpc::Channel>& channel);

}  // namespace stiefel::test
