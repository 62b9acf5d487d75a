#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "engine/catalogue/system_entry.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// Computes the energy ½ Σ m_k²/I_k, I_1 = λ_2 + λ_3 and cyclic, of a body in three dimensions from
/// what Simulation::save gives: (q; m), or m alone, before everything else. It has the bits of the
/// energy among `Simulation::invariants`, because it makes the same sums in extended precision, and
/// does not allocate.
class EnergyOfBody {
 public:
  /// Returns nullopt where the scene is not such a body. `E` is the energy at step 0 among the
  /// invariants of `start`; returns nullopt where this computation differs from it in a bit.
  static std::optional<EnergyOfBody> make(const Scene& scene, const Simulation& start,
                                          long double E) {
    const bool body = system_entry(scene.system())->packed && scene.dimension() == 3;
    const std::size_t first = scene.has_frame() ? 4 : 0;
    if (!body || scene.in_float() || start.saved_size() < first + 3) return std::nullopt;
    const EnergyOfBody energy(scene, first);
    std::vector<double> saved(start.saved_size());
    start.save(saved);
    if (energy(saved) != E) return std::nullopt;
    return energy;
  }

  long double operator()(std::span<const double> saved) const {
    const double* m = saved.data() + first_;
    long double sum = 0;
    for (const int k : {2, 1, 0}) sum += static_cast<long double>(m[k]) * m[k] / I_[k];
    return sum / 2;
  }

 private:
  EnergyOfBody(const Scene& scene, std::size_t first) : first_(first) {
    const Eigen::VectorXd& lambda = scene.inertia();
    for (const int k : {0, 1, 2})
      I_[k] = static_cast<long double>(lambda((k + 1) % 3)) + lambda((k + 2) % 3);
  }

  std::size_t first_;
  std::array<long double, 3> I_;
};

}  // namespace stiefel
