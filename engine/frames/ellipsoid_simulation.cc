#include "engine/frames/body/ellipsoid_invariants.h"
#include "engine/frames/ellipsoid_maps.h"
#include "engine/frames/stiefel_forms.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"
#include "engine/stepping/stacked_observables.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

using Wide = long double;

/// Returns q̇ from the rows q and q̇, or q and p of a costate.
Eigen::VectorXd velocity(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& x, bool costate) {
  if (!costate) return x.row(1);
  EllipsoidCostate<double> system(lambda);
  Eigen::MatrixXd dx = x;
  system.field(x, dx);
  return dx.row(0);
}

std::unique_ptr<Simulation> make_ellipsoid(const Scene& scene) {
  const bool costate = scene.block("p").size() > 0;
  const Eigen::VectorXd lambda = scene.inertia();
  StackedObservables observables(stacked(scene, "q", costate ? "p" : "qdot"));
  observables.block("q", 0, 1).block(costate ? "p" : "qdot", 1, 1);
  const SizeOf terms = terms_of_S(scene, 1, costate);
  report_geodesic(
      observables, scene, 1,
      [=](const Eigen::MatrixXd& x) -> Eigen::MatrixXd {
        return velocity(lambda, x, costate).cwiseProduct(lambda).transpose();
      },
      terms);
  const auto energy = std::move(observables.all_invariants);
  observables.all_invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    energy(x, out);
    const Eigen::VectorXd q = x.row(0), qdot = velocity(lambda, x, costate);
    if (out.wants(family::joachimsthal)) {
      const Wide J = joachimsthal<Wide>(lambda.cast<Wide>(), q.cast<Wide>(), qdot.cast<Wide>());
      // The scale is (qᵀΛ⁻¹q)‖q̇‖², or what it would be for a q̇ of the size of its terms.
      const Wide of_terms = terms(x) / lambda.minCoeff();
      const bool at_rest = is_rounding(qdot.stableNorm(), static_cast<double>(of_terms));
      out.add(family::joachimsthal, J, at_rest ? of_terms * of_terms / lambda.maxCoeff() : J);
    }
    if (!out.wants(family::lax, lambda.size() <= largest_lax_unasked)) return;
    const Vector<Wide> wide_q = q.cast<Wide>();
    const Vector<Wide> p = costate ? Vector<Wide>(x.row(1).transpose().cast<Wide>())
                                   : Vector<Wide>(lambda.cwiseProduct(qdot).cast<Wide>());
    const int K = static_cast<int>(lambda.size());
    const auto coefficients = lax_coefficients<Wide>(lambda.cast<Wide>(), wide_q, p, K);
    for (int k = 1; k <= K; ++k) {
      Wide size = 0;
      for (const Wide c : coefficients[k - 1]) size = std::max(size, std::abs(c));
      for (std::size_t j = 0; j < coefficients[k - 1].size(); ++j)
        out.add(family::lax, indexed(family::lax, k, static_cast<long>(j) - k),
                coefficients[k - 1][j], size);
    }
  };
  if (costate) return make_simulation(scene, EllipsoidCostate<double>(lambda), shared(observables));
  return make_simulation(scene, Ellipsoid<double>(lambda), shared(observables));
}

/// Returns why a method that applies to (q, qdot) does not apply to (q, p); empty if it does.
std::string refusal(const Scene& scene, std::string_view method) {
  if (scene.block("p").size() == 0) return "";
  std::string others;
  for (const auto& on : methods_on<EllipsoidCostate<double>>({})) {
    if (on.method == method) return "";
    others += (others.empty() ? "" : " or ") + std::string(on.method);
  }
  return "does not accept the costate p; give qdot, or use " + others;
}

}  // namespace

Simulations ellipsoid_simulations() {
  return {make_ellipsoid, methods_on<Ellipsoid<double>>, refusal};
}

}  // namespace stiefel
