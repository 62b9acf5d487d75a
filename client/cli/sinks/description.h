#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "stiefel/client/session.h"

namespace stiefel::cli {

/// What a field is, by its name: how many axes a value has (2 for a matrix, 1 for a vector, 0 for a
/// number), the names of a vector's numbers in a table, and the unit in a scene with `body`.
struct FieldKind {
  int axes = 2;
  std::vector<std::string_view> columns;
  std::string_view unit;
};
const FieldKind& kind_of(std::string_view field);

/// Returns the shape (..., rows, cols) of a field, or (..., rows, cols, x) with one axis `behind`,
/// without the axes of length 1 of a vector or a number.
std::vector<std::size_t> named_shape(std::string_view field, std::vector<std::size_t> shape,
                                     int behind = 0);
/// Returns the shape of one sample of a field: the axes of the tensor behind the samples.
std::vector<std::size_t> sample_shape(const v1::Field& field);
/// Returns the type of a tensor's numbers as numpy names it: "<f8".
std::string numpy_type(v1::DataType type);

/// What a file says of a run beside its samples: the resolved scene, the numerics id of the build,
/// and what `stiefel rerun` needs to run it again.
class Description {
 public:
  Description() = default;
  /// `run`: what the samples are of, {"to", "start", "every"} or {"times"}. `epoch`: that of the
  /// scene; empty if it has none.
  Description(const client::Session& session, nlohmann::ordered_json run, const std::string& epoch);

  /// Takes names, shapes and types of the fields from the first samples.
  void take(const v1::StreamResponse& batch);
  /// Returns the unit of a field or of "time"; empty where the scene gives none.
  std::string unit_of(std::string_view name) const;
  /// Returns {"format", "numerics_id", "scene", "run", "fields", "units"}.
  nlohmann::ordered_json json() const;

 private:
  nlohmann::ordered_json scene_, run_, fields_ = nlohmann::ordered_json::object();
  std::string numerics_id_;
  bool in_si_ = false;
};

inline constexpr const char* trajectory_format = "stiefel.trajectory";

}  // namespace stiefel::cli
