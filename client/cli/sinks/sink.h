#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "client/cli/sinks/description.h"
#include "stiefel/v1/simulation.pb.h"

namespace stiefel::cli {

/// Writes samples to a file. It takes one message at a time, so that a run of any length needs
/// little memory.
class Sink {
 public:
  virtual ~Sink() = default;
  /// Tells, before the first message, what the file says of the run beside the samples.
  void describe(Description description) { description_ = std::move(description); }
  virtual void write(const v1::StreamResponse& batch) = 0;
  /// Completes the file after the last message; without this call no file appears. `report` is what
  /// cli::report (report.h) returns, `ending` what cli::ending does.
  virtual void finish(const nlohmann::ordered_json& report,
                      const nlohmann::ordered_json& ending) = 0;

 protected:
  Description description_;
};

std::unique_ptr<Sink> make_json_sink(const std::string& path);  ///< stdout if the path is empty
std::unique_ptr<Sink> make_csv_sink(const std::string& path);
std::unique_ptr<Sink> make_npz_sink(const std::string& path);

/// Returns the sink for the path's extension; JSON on stdout if the path is empty. Throws BadInput
/// for an unknown extension.
std::unique_ptr<Sink> make_sink(const std::string& path);

/// Appends the shortest decimal that reads back to the same bits, always as a floating-point
/// number: a reader that took -0 for an integer would lose its sign.
void append_number(std::string& text, double number);

}  // namespace stiefel::cli
