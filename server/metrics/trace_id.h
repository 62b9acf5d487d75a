#pragma once

#include <string_view>

namespace stiefel::server {

/// Returns the trace id, 32 hexadecimal digits, of a W3C header `traceparent`: version, trace id,
/// parent id and flags, in lower case. Empty if the header is not valid: wrong length, version ff,
/// or an id of zeros. Versions after 00 may have more behind the flags.
std::string_view trace_id(std::string_view traceparent);

}  // namespace stiefel::server
