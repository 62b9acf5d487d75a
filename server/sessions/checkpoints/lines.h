#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace stiefel::server {

/// A line of a text file: its number, counted from 1, and its text without surrounding spaces.
struct Line {
  std::size_t number;
  std::string_view text;
};

/// Returns the lines that are neither empty nor begin with #, as views into `text`.
std::vector<Line> meaningful_lines(std::string_view text);

/// Removes the first word, up to a space or tab, from `text` and returns it.
std::string_view next_word(std::string_view& text);

}  // namespace stiefel::server
