#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/exit_status.h"
#include "client/cli/origin.h"

namespace stiefel::cli {

/// The server of a command.
struct Remote {
  std::string address = {};     ///< empty: the command embeds a server
  std::string tls_ca = {};      ///< path of a file of authorities; empty: no TLS
  std::string token_file = {};  ///< path of a file; empty: the variable STIEFEL_TOKEN
};

// Each command throws BadInput or client::Error where it has no outcome. `estimate_error` says
// always or never; without a value, the error is estimated when that takes less work than the run
// or less than 10 ms.

struct DescribeCommand {
  Remote server;
  bool json = false;
};
ExitStatus describe(const DescribeCommand& command);

struct RunCommand {
  std::string scene;
  Remote server;
  std::int64_t from = 0;
  std::int64_t to = 0;
  std::optional<std::int64_t> every;
  std::string times;  ///< a file of times, instead of from, to and every
  std::vector<std::string> fields;
  std::string output;
  std::optional<bool> estimate_error;
};
/// Sets `origin.times` if the command has a file of times.
ExitStatus run(const RunCommand& command, Origin& origin);

/// Without --every, `run` samples every step if that gives at most this many samples, else only the
/// first and the last step.
constexpr std::int64_t max_default_samples = 1000;

struct DiagnoseCommand {
  std::string scene;
  Remote server;
  std::int64_t to = 0;
  std::vector<std::string> invariants;
  /// A file with `forms` and `dirac_brackets`, as in stiefel.v1.DiagnoseRequest.
  std::string structure;
  bool symplectic = false;
  std::optional<bool> estimate_error;
};
ExitStatus diagnose(const DiagnoseCommand& command);

struct SummarizeCommand {
  std::string scene;
  Remote server;
  std::int64_t from = 0;
  std::int64_t to = 0;
  std::int64_t every = 1;
  /// "energy=drift", "M=min,max".
  std::vector<std::string> quantities;
  /// A file with `quantities`, `events` and `fields`, as in stiefel.v1.SummarizeRequest.
  std::string request;
  bool over_members = false;
  std::string output;
};
ExitStatus summarize(const SummarizeCommand& command);

struct ConvertCommand {
  std::string scene;
  Remote server;
  std::string target;
  std::optional<double> epsilon;
  std::optional<double> parameter;
  std::string output;
};
ExitStatus convert(const ConvertCommand& command);

struct TradeoffCommand {
  std::string scene;
  Remote server;
  std::optional<double> horizon;
  std::optional<double> budget;
  std::optional<std::uint32_t> repeats;
  bool all = false;  ///< prints all the points, not only the front
  std::string output;
};
ExitStatus tradeoff(const TradeoffCommand& command);

struct ConnectCommand {
  std::string file;
  Remote server;
};
/// Sets `origin.single_pair` if the file gives its frames outside of the list `pairs`.
ExitStatus connect(const ConnectCommand& command, Origin& origin);

}  // namespace stiefel::cli
