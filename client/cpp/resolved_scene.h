#pragma once

#include <string>

#include "stiefel/v1/scene.pb.h"
#include "stiefel/v1/tensor.pb.h"

namespace stiefel::client {

using Names = google::protobuf::RepeatedPtrField<std::string>;

/// The resolved scene: `base` with what the server filled in, each field (of `body` each of its
/// fields) in the place of the base's, and without the fields that `cleared` names. It is whole
/// when `set_array` has put the arrays in that travel for themselves; `left_out` has their paths.
v1::Scene resolved_scene(v1::Scene base, const v1::Scene& filled_in, const Names& cleared,
                         const Names& left_out);

/// Puts an array of a scene where it belongs. Its name is its path in the scene: "initial.Q",
/// "inertia", "body.attitude". Throws CorruptReply for a path that no scene has.
void set_array(const v1::Field& array, v1::Scene* scene);

}  // namespace stiefel::client
