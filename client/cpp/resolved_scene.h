#pragma once

#include <string>

#include "stiefel/v1/scene.pb.h"
#include "stiefel/v1/tensor.pb.h"

namespace stiefel::client {

using Names = google::protobuf::RepeatedPtrField<std::string>;

/// Returns the resolved scene: `base`, in which each field of `filled_in` (inside `body`, each of
/// its fields) replaces the base's, without the fields that `cleared` names. `left_out` has the
/// paths of arrays that travel separately; the scene is whole when `set_array` has added them.
v1::Scene resolved_scene(v1::Scene base, const v1::Scene& filled_in, const Names& cleared,
                         const Names& left_out);

/// Sets an array of a scene. The name of the array is its path in the scene: "initial.Q",
/// "inertia", "body.attitude". Throws CorruptReply for a path that no scene has.
void set_array(const v1::Field& array, v1::Scene* scene);

}  // namespace stiefel::client
