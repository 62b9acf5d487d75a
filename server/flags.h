#pragma once

#include <CLI/App.hpp>
#include <string>

#include "server/server.h"

namespace stiefel::server {

/// What the command stiefel-server is told by flags and environment variables.
struct Flags {
  Flags();
  /// Defines the flags; the values are here once `app` has parsed.
  void add_to(CLI::App& app);
  /// For the constructor of Server.
  Options options() const;

  bool exit_with_parent = false;

 private:
  void add_access_to(CLI::App& app);

  Options options_;
  double idle_timeout_, grace_;  // seconds
  double max_connection_age_ = 0, self_watch_ = 0;
  std::string log_format_ = "text";
  std::string memory_, principal_memory_ = "0";
};

/// What CLI11 puts after "--listen: ": the rule that the address breaks, or nothing.
std::string sound_address(const std::string& address);

/// The flags of `app` as a table in Markdown: flag, variable, default, meaning.
std::string flag_table(const CLI::App& app);

}  // namespace stiefel::server
