#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "stiefel/v1/simulation.pb.h"

namespace stiefel::cli {

/// Writes samples to a file. It takes one message at a time, so that a run of any length needs
/// little memory.
class Sink {
 public:
  virtual ~Sink() = default;
  virtual void write(const v1::StreamResponse& batch) = 0;
  /// Completes the file after the last message; without this call no file appears. `report` is what
  /// cli::report (report.h) returns.
  virtual void finish(const nlohmann::ordered_json& report) = 0;
};

std::unique_ptr<Sink> make_json_sink(const std::string& path);  ///< stdout if the path is empty
std::unique_ptr<Sink> make_csv_sink(const std::string& path);
std::unique_ptr<Sink> make_npz_sink(const std::string& path);

/// What a field is, by its name: how many axes a value has (2 for a matrix, 1 for a vector, 0 for a
/// number), the names of a vector's numbers in a table, and the unit in a scene with `body`.
struct FieldKind {
  int axes = 2;
  std::vector<std::string_view> columns;
  std::string_view unit;
};
const FieldKind& kind_of(std::string_view field);

/// Returns the sink for the path's extension; JSON on stdout if the path is empty. Throws BadInput
/// for an unknown extension.
std::unique_ptr<Sink> make_sink(const std::string& path);

/// Appends the shortest decimal that reads back to the same bits, always as a floating-point
/// number: a reader that took -0 for an integer would lose its sign.
void append_number(std::string& text, double number);

}  // namespace stiefel::cli
