#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace stiefel::server {

/// A line of a file that people write: its number, from 1, and its text without the spaces around
/// it.
struct Line {
  std::size_t number;
  std::string_view text;
};

/// The lines that are neither empty nor begin with #. They refer to `text`.
std::vector<Line> meaningful_lines(std::string_view text);

/// Cuts the first word off `text`, up to spaces or tabs, and returns it.
std::string_view next_word(std::string_view& text);

}  // namespace stiefel::server
