#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "server/sessions/identity.h"
#include "stiefel/v1/common.pb.h"
#include "stiefel/v1/scene.pb.h"
#include "stiefel/v1/session.pb.h"

namespace stiefel::server {

/// Arrays that are sent in messages of limited size.
class Parts {
 public:
  using Fields = google::protobuf::RepeatedPtrField<v1::Field>;

  void add(v1::Field whole) { fields_.push_back(std::move(whole)); }
  bool empty() const { return fields_.empty(); }
  /// Moves about `budget` bytes to `out`: whole arrays, and at the end a part of one, which ends
  /// with a row if a row fits. Moves at least one element.
  void take(std::size_t budget, Fields* out);

 private:
  std::deque<v1::Field> fields_;
  std::size_t sent_ = 0;  ///< bytes of the first array that were taken
};

/// An array of a description: a block, or a list of numbers as one row.
struct SceneArray {
  std::string path;  ///< "initial.Q", "inertia", "body.attitude"
  Eigen::Index rows, cols;
  const double* values;
  const double* imaginary;  ///< null if the array is real

  std::size_t bytes() const {
    return static_cast<std::size_t>(rows * cols) * sizeof(double) * (imaginary ? 2 : 1);
  }
};

/// Returns the arrays that a description sets, in the order of the fields.
std::vector<SceneArray> arrays_of(const SceneDescription& description);

/// Returns an array as a field named by its path.
v1::Field to_field(const SceneArray& array);

/// Writes what the view shows of a resolved description; for UNSPECIFIED, what was filled in.
/// Leaves out the largest arrays until the rest fits into a reply, and returns their paths.
std::vector<std::string> write_view(const SceneDescription& resolved, const Difference& difference,
                                    v1::SceneView view, v1::Scene* out);

}  // namespace stiefel::server
