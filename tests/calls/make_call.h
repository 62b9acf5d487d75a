#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <string>

#include "tests/calls/calls.pb.h"

namespace stiefel::test {

/// Reads every_call.txtpb.
Calls every_call();

/// Returns the name of a call's RPC in lower case: "create_session"; "" of an empty call.
std::string name_of(const Call& call);

/// Makes the call and passes each reply to `take`, which ends the call when it returns false: the
/// status is then CANCELLED. An error that a reply of Drive holds ends the call with that error.
grpc::Status make(const std::shared_ptr<grpc::Channel>& channel, grpc::ClientContext& context,
                  const Call& call,
                  const std::function<bool(const google::protobuf::Message&)>& take);

}  // namespace stiefel::test
