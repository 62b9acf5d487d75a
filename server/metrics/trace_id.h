#pragma once

#include <string_view>

namespace stiefel::server {

/// The trace id, 32 hexadecimal digits, of a W3C header `traceparent`: version, trace id, parent id
/// and flags, in lower case. Empty where the header breaks the rules: an unknown length, version
/// ff, or an id of zeros. Versions after 00 may have more behind the flags.
std::string_view trace_id(std::string_view traceparent);

}  // namespace stiefel::server
