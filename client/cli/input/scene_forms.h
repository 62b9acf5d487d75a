#pragma once

#include <google/protobuf/descriptor.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace stiefel::cli {

/// Returns a message with what a scene file may have beside the fields of stiefel.v1.Scene:
/// `epoch`, `normalize`, and in `body` `order`, `mrp`, `angular_momentum` and `frame`.
const google::protobuf::Descriptor* beside_the_scene();

/// Writes a method that is given as its name as the object {"name": …}.
void write_out_method(nlohmann::json& scene);

/// Writes the forms in which people have a scene as the fields of stiefel.v1.Scene, as the Python
/// client does (docs/conventions.md):
/// - body: an inertia tensor as a symmetric 3 × 3 matrix; an attitude as a rotation matrix, as a
///   quaternion in the order "xyzw", or as `mrp`; `angular_momentum`, and with `frame` "space" the
///   velocity or momentum in space axes;
/// - initial: Omega, of which it makes M = ΛΩ + ΩΛ, and Qdot, of which it makes M, S or P;
/// - method: its name alone;
/// - `normalize`: makes what was rounded to a few digits fit, and a quaternion of any norm.
///
/// `epoch` stays. Lists may be nested, with one list for each member of an ensemble. Throws
/// BadInput that calls the scene `name`. Returns the places of the blocks that stand for others:
/// {"initial.M", "initial.Omega"}.
std::map<std::string, std::string> write_out_forms(const std::string& name, nlohmann::json& scene);

}  // namespace stiefel::cli
