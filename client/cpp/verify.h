#pragma once

#include <cstdint>
#include <string>

#include "proto/checksum/checksum.h"
#include "stiefel/client/error.h"

namespace stiefel::client {

/// Throws CorruptReply for a checksum `told` other than `computed`, and for a checksum that is
/// absent although it was `asked` for. `what` names the message in the error.
inline void verify(bool present, std::uint32_t told, std::uint32_t computed,
                   const std::string& what, bool asked) {
  if (!present && asked) throw CorruptReply(what + " has no checksum, which was asked for");
  if (present && told != computed)
    throw CorruptReply("the checksum of " + what +
                       " does not match its numbers: the reply was corrupted in transit");
}

/// Throws CorruptReply if the message has a checksum that its numbers do not match, or none
/// although it was `asked` for. `what` names the message in the error: "the state at step 5".
template <class Message>
void verify(const Message& message, const std::string& what, bool asked) {
  if (message.has_checksum() || asked)
    verify(message.has_checksum(), message.checksum(), wire::checksum(message), what, asked);
}

/// Does the same for both checksums of a diagnosis.
inline void verify_both(const v1::DiagnoseResponse& diagnosis, const std::string& what,
                        bool asked) {
  verify(diagnosis, what, asked);
  verify(diagnosis.has_details_checksum(), diagnosis.details_checksum(),
         wire::details_checksum(diagnosis), what, asked);
}

}  // namespace stiefel::client
