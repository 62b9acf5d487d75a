#pragma once

namespace stiefel {

struct TwoForm;

/// The two-forms of the papers (two_forms.h), for SystemEntry::two_forms.
namespace two_form {
extern const TwoForm of_bodies;           ///< (Q, M), [RB] (3.13)
extern const TwoForm of_symmetric_pairs;  ///< (Q, P), [RB] (3.5)
extern const TwoForm of_two_frames;       ///< (Q_prev, Q), [RB] (7.8)
extern const TwoForm of_tangent_pairs;    ///< (Q, S), [ST] (63)
extern const TwoForm of_costate_pairs;    ///< (Q, P) on V(n, N), [ST] (63), (71)
extern const TwoForm of_cotangent_pairs;  ///< (Q, S), [ST] (93)
}  // namespace two_form

}  // namespace stiefel
