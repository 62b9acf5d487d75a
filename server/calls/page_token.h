#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace stiefel::server {

/// Where a page of ListSessions ended, as an opaque token, and back. Nothing for what is no token.
std::string page_token(std::string_view last_id);
std::optional<std::string> read_page_token(std::string_view token);

}  // namespace stiefel::server
