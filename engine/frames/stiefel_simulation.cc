#include "engine/frames/body/stiefel_momenta.h"
#include "engine/frames/stiefel_forms.h"
#include "engine/frames/stiefel_maps.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make_stiefel(const Scene& scene) {
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  StackedObservables observables(stacked(scene, "Q", "S"));
  observables.block("Q", 0, static_cast<int>(n));
  observables.block("S", static_cast<int>(n), static_cast<int>(n));
  report_geodesic(
      observables, scene, n, [n](const auto& x) { return x.bottomRows(n).eval(); },
      terms_of_S(scene, n, false));
  if (N <= largest_written_M)
    observables.field(
        {"M", static_cast<int>(N), static_cast<int>(N)},
        [n](const auto& x, auto out) { out = dense_M<double>(x.topRows(n), x.bottomRows(n)); });
  return make_simulation(scene, Stiefel<double>(scene.inertia(), n),
                         shared(std::move(observables)));
}

}  // namespace

Simulations stiefel_simulations() { return {make_stiefel, methods_on<Stiefel<double>>}; }

}  // namespace stiefel
