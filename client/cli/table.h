#pragma once

#include <string>
#include <vector>

namespace stiefel::cli {

using Rows = std::vector<std::vector<std::string>>;

/// Columns as wide as their widest cell, two blanks between, on stdout.
void print_table(const Rows& rows, const std::string& indent = "");

}  // namespace stiefel::cli
