#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace stiefel::server {

/// Converts the last id of a page of ListSessions to an opaque token, and back; returns nothing for
/// a text that is not a token.
std::string page_token(std::string_view last_id);
std::optional<std::string> read_page_token(std::string_view token);

}  // namespace stiefel::server
