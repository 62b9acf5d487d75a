#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "engine/catalogue/system_entry.h"
#include "engine/double_bracket/double_bracket.h"
#include "engine/double_bracket/double_bracket_invariants.h"
#include "engine/linalg/matrix_equations/skew_spectrum.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"
#include "engine/stepping/stacked_observables.h"
#include "stiefel/invariant_names.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Complex = std::complex<double>;

Eigen::MatrixXcd complex_block(const Eigen::MatrixXd& x, Eigen::Index first, Eigen::Index p) {
  return x.middleRows(first, p).cast<Complex>() +
         Complex(0, 1) * x.middleRows(first + p, p).cast<Complex>();
}

std::unique_ptr<Simulation> make_double_bracket(const Scene& scene) {
  const auto vector = [](const std::vector<double>& l) -> Eigen::VectorXd {
    return Eigen::Map<const Eigen::VectorXd>(l.data(), static_cast<Eigen::Index>(l.size()));
  };
  const Eigen::VectorXd lambda_u = vector(scene.description().inertia_u);
  const Eigen::VectorXd lambda_v = vector(scene.description().inertia_v);
  const int p = static_cast<int>(lambda_u.size()), q = static_cast<int>(lambda_v.size());
  Eigen::MatrixXd state(4 * p, q);
  state << scene.block("Q"), scene.block("P");
  StackedObservables observables(state);
  for (const auto& [name, first] : {std::pair("Q", 0), std::pair("P", 2 * p)})
    observables.computed_block({name, p, q, true}, [first, p](const auto& x, auto out) {
      for (Eigen::Index j = 0; j < x.cols(); ++j) {
        out.col(2 * j) = x.col(j).segment(first, p);
        out.col(2 * j + 1) = x.col(j).segment(first + p, p);
      }
    });
  observables.all_invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    const Eigen::MatrixXcd Q = complex_block(x, 0, p), P = complex_block(x, 2 * p, p);
    if (out.wants(family::hamiltonian)) {
      const double H = double_bracket_hamiltonian<double>(lambda_u, lambda_v, Q, P);
      // √H is a norm of PQ† − QP† and P†Q − Q†P; of_terms is the norm of the products in these
      // differences.
      const double least = std::min(lambda_u.minCoeff(), lambda_v.minCoeff());
      const long double of_terms = Q.stableNorm() * P.stableNorm() / std::sqrt(8 * least);
      const bool at_rest = is_rounding(std::sqrt(H), static_cast<double>(of_terms));
      out.add(family::hamiltonian, H, at_rest ? of_terms * of_terms : H);
    }
    const std::pair<Complex, Complex> combinations[] = {{1, 0}, {0, 1}, {1, 1}, {1, {0, 1}}};
    if (!out.wants(family::singular_values)) return;
    double largest[2] = {0, 0};  // ‖Q‖ and ‖P‖
    for (int c = 0; c < 4; ++c) {
      const auto [a, b] = combinations[c];
      const Eigen::VectorXd s = singular_values(Q, P, a, b);
      if (c < 2) largest[c] = s(0);
      // Q + P may be small, or 0; its singular values change by the rounding of Q and P, so the
      // scale is that of Q and P.
      const double scale = std::abs(a) * largest[0] + std::abs(b) * largest[1];
      for (Eigen::Index i = 0; i < s.size(); ++i)
        out.add(family::singular_values, indexed(family::singular_values, c, i), s(i), scale);
    }
  };
  stop_point();
  // Shared by the copies of the observables: its workspace has tens of megabytes where p + q = 512.
  const auto system = std::make_shared<DoubleBracket<double>>(lambda_u, lambda_v);
  observables.speed = [system](const Eigen::MatrixXd& x) {
    auto xi = system->zero();
    system->generator(x, xi);
    if (!xi.allFinite()) return std::numeric_limits<double>::infinity();
    return casimirs<double>(xi)(0);  // U and V form one real skew matrix
  };
  stop_point();
  return make_simulation(scene, *system, shared(observables));
}

}  // namespace

Simulations double_bracket_simulations() {
  return {make_double_bracket, methods_on<DoubleBracket<double>>};
}

}  // namespace stiefel
