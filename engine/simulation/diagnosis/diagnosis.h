#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/simulation/catalogue/catalogue.h"
#include "engine/simulation/run/simulation.h"

namespace stiefel {

/// One number that the exact motion keeps: "energy", "spatial_momentum[1,2]", "manakov[3,1]" (the
/// coefficient of μ¹ in tr(M + μΛ²)³), "casimirs[1]".
struct InvariantDrift {
  std::string name;
  long double initial;
  long double value;
  long double scale;
  Conservation conservation;
  std::optional<std::int64_t> member = {};  ///< of an ensemble: the one whose drift is the largest
  double drift() const { return drift_of(initial, value, scale); }
};

struct Diagnosis {
  std::vector<InvariantDrift> invariants;
  std::optional<double> orthogonality;  ///< max |QQᵀ − I|
  double h_omega;                       ///< |h| ‖Ω‖, or |h| ‖Q̇‖ where n < N
  std::optional<double> largest_step;
};

/// The families of invariants that can be asked for: "energy", "spatial_momentum", ...
bool is_invariant(const Scene& scene, std::string_view name_or_family);

/// Invariants of `now` beside those at step 0. `only`: families or names; when empty every family,
/// the Manakov coefficients up to N = 16 (they cost N⁵ operations).
Diagnosis diagnose(const Scene& scene, const Simulation& now,
                   std::span<const std::string> only = {});

}  // namespace stiefel
