#pragma once

#include <string>

#include "proto/checksum/checksum.h"
#include "stiefel/client/error.h"

namespace stiefel::client {

/// Throws CorruptReply if the message has a checksum that its numbers do not match. `what` names
/// the message in the error: "the sample of step 5".
template <class Message>
void verify(const Message& message, const std::string& what) {
  if (!message.has_checksum() || wire::checksum(message) == message.checksum()) return;
  throw CorruptReply("the checksum of " + what +
                     " does not match its numbers: the reply was corrupted in transit");
}

}  // namespace stiefel::client
