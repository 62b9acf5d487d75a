#pragma once

#include <CLI/App.hpp>
#include <string>

#include "server/server.h"

namespace stiefel::server {

/// The values of the flags and environment variables of the command stiefel-server.
struct Flags {
  /// Adds the flags to `app`, whose parsing sets the values here.
  explicit Flags(CLI::App& app);
  Flags(const Flags&) = delete;
  Flags& operator=(const Flags&) = delete;

  Options options;
  bool exit_with_parent = false;
};

/// Returns the rule that the address breaks, which CLI11 puts after "--listen: "; empty if none.
std::string address_error(const std::string& address);

/// Returns the flags of `app` as a table in Markdown: flag, variable, default, meaning.
std::string flag_table(const CLI::App& app);

}  // namespace stiefel::server
