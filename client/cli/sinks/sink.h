#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "stiefel/v1/simulation.pb.h"

namespace stiefel::cli {

/// Where samples go, a message at a time, so that a run of any length needs little memory.
class Sink {
 public:
  virtual ~Sink() = default;
  virtual void write(const v1::StreamResponse& batch) = 0;
  /// After the last message; without it no file appears. `report` is report.h's.
  virtual void finish(const nlohmann::ordered_json& report) = 0;
};

std::unique_ptr<Sink> make_json_sink(const std::string& path);  ///< stdout if the path is empty
std::unique_ptr<Sink> make_csv_sink(const std::string& path);
std::unique_ptr<Sink> make_npz_sink(const std::string& path);

/// By the path's extension; JSON on stdout if it is empty. Throws BadInput.
std::unique_ptr<Sink> make_sink(const std::string& path);

/// Appends the shortest decimal that reads back to the same bits, always as a floating-point number
/// (a reader that took -0 for an integer would lose its sign).
void append_number(std::string& text, double number);

}  // namespace stiefel::cli
