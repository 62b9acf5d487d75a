#pragma once

#include <CLI/App.hpp>
#include <string>

#include "server/server.h"

namespace stiefel::server {

/// The values of the flags and environment variables of the command stiefel-server.
struct Flags {
  Flags();
  /// Adds the flags to `app`, whose parsing sets the values here.
  void add_to(CLI::App& app);
  /// Returns the options for the constructor of Server.
  Options options() const;

  bool exit_with_parent = false;

 private:
  void add_access_to(CLI::App& app);

  Options options_;
  double idle_timeout_, grace_;  // seconds
  double max_connection_age_ = 0, self_watch_ = 0;
  std::string log_format_ = "text";
  std::string memory_, principal_memory_;
};

/// Returns the rule that the address breaks, which CLI11 puts after "--listen: "; empty if none.
std::string address_error(const std::string& address);

/// Returns the flags of `app` as a table in Markdown: flag, variable, default, meaning.
std::string flag_table(const CLI::App& app);

}  // namespace stiefel::server
