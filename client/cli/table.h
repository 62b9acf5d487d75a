#pragma once

#include <string>
#include <vector>

namespace stiefel::cli {

using Rows = std::vector<std::vector<std::string>>;

/// Prints a table to stdout. Columns are as wide as their widest cell, with two blanks between
/// them.
void print_table(const Rows& rows, const std::string& indent = "");

}  // namespace stiefel::cli
