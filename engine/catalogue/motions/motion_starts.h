#pragma once

namespace stiefel {

struct MotionStart;

/// Starts of the Taylor series of the systems' motions (series_start.h), for SystemEntry::motion.
namespace motion_start {
extern const MotionStart body;  ///< (Q, M), M alone, or a body in engineers' terms
extern const MotionStart right_body, symmetric_body, right_symmetric_body, reduced_body;
extern const MotionStart mclachlan_scovel, parametric_body;
extern const MotionStart two_frames;                ///< (Q_prev, Q) of the discrete body
extern const MotionStart tangent, costate, vector;  ///< on V(n, N): (Q, S), (Q, P); n = 1
extern const MotionStart double_bracket;
}  // namespace motion_start

}  // namespace stiefel
