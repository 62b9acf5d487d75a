#pragma once

namespace stiefel {

struct Representation;

/// How the blocks of a system stand for a phase (phase.h), for SystemEntry::representation.
namespace representation {
// [RB]: n = N.
extern const Representation body, right_body, symmetric_body, right_symmetric_body;
extern const Representation mclachlan_scovel, two_frames, parametric_body, discrete_parametric_body;
extern const Representation interpolation;  ///< no system
// [ST]: n <= N; at n = N they read and write M.
extern const Representation tangent, costate, momentum, vector, frames;
extern const Representation velocity, angular_velocity;  ///< no systems
}  // namespace representation

}  // namespace stiefel
