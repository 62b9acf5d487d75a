#pragma once

#include <string_view>

namespace stiefel::cli {

/// Returns the page of `stiefel report`, in which "@DATA@" stands for its data as JSON. It is the
/// file client/python/stiefel/_report/page.html.
std::string_view page_template();

}  // namespace stiefel::cli
