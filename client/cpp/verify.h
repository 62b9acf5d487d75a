#pragma once

#include <string>

#include "proto/checksum/checksum.h"
#include "stiefel/client/error.h"

namespace stiefel::client {

/// Whether the message has no checksum, or one that its numbers match.
template <class Message>
bool is_sound(const Message& message) {
  return !message.has_checksum() || wire::checksum(message) == message.checksum();
}

/// Whether each of the two checksums of a diagnosis is absent or one that the numbers match. A
/// server that is older than `details_checksum` sends only the first.
inline bool is_sound(const v1::DiagnoseResponse& diagnosis) {
  return is_sound<v1::DiagnoseResponse>(diagnosis) &&
         (!diagnosis.has_details_checksum() ||
          wire::details_checksum(diagnosis) == diagnosis.details_checksum());
}

/// Throws CorruptReply if the message has a checksum that its numbers do not match. `what` names
/// the message in the error: "the sample of step 5".
template <class Message>
void verify(const Message& message, const std::string& what) {
  if (is_sound(message)) return;
  throw CorruptReply("the checksum of " + what +
                     " does not match its numbers: the reply was corrupted in transit");
}

}  // namespace stiefel::client
