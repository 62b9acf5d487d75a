#pragma once

#include <expected>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/simulation/catalogue/catalogue.h"
#include "engine/simulation/scene/scene.h"

namespace stiefel {

class Simulation;

/// The two-forms of a system, and the blocks of which its tangent vectors are made.
std::vector<FormInfo> forms_of(std::string_view system);

/// A tangent vector by the names of the state's blocks.
using TangentVector = std::map<std::string, Block>;

/// ω(u, v) at the state of `now`. Refused: a form that the system does not have, blocks that are
/// not the form's, and vectors that are not tangent to 1e-8. The violations are of the fields
/// "form", "first" and "second" of `place`.
std::expected<double, Violations> evaluate_form(const Scene& scene, const Simulation& now,
                                                const std::string& form, const TangentVector& u,
                                                const TangentVector& v, const Place& place);

/// max |ω(Tφu, Tφv) − ω(u, v)| / ‖u‖‖v‖ over `pairs` seeded pairs of tangent vectors at the state
/// of `now`, φ one step of the scene's method and ω the system's first form. About 1e-12 for a
/// symplectic φ; nothing where φ is not defined around the state. Refused for a system that has no
/// form, as a violation of `place`.
std::expected<std::optional<double>, Violations> symplectic_defect(const Scene& scene,
                                                                   const Simulation& now, int pairs,
                                                                   unsigned seed,
                                                                   const Place& place);

/// A product of functions tr AᵀQ + tr BᵀP, given as A and B.
struct PairFactors {
  std::vector<std::pair<RowMatrix, RowMatrix>> factors;
};

/// The Dirac bracket {F, K} on S, [RB] (3.15), at the state (Q, P) of `now`. Refused for systems
/// without a P and for matrices that are not N × N. The violations are of the fields "first" and
/// "second" of `place`.
std::expected<double, Violations> dirac_bracket(const Scene& scene, const Simulation& now,
                                                const PairFactors& F, const PairFactors& K,
                                                const Place& place);

}  // namespace stiefel
