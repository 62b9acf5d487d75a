#pragma once

namespace stiefel {

struct Representation;

/// The representations of the systems: the maps between their blocks and a phase (phase.h), for
/// SystemEntry::representation.
namespace representation {
// [RB]: n = N.
extern const Representation body, right_body, symmetric_body, right_symmetric_body;
extern const Representation mclachlan_scovel, two_frames, parametric_body, discrete_parametric_body;
extern const Representation interpolation;  ///< not a system
// [ST]: n <= N; at n = N they read and write M.
extern const Representation tangent, costate, momentum, vector, frames;
extern const Representation velocity, angular_velocity;  ///< not systems
}  // namespace representation

}  // namespace stiefel
