#include "server/pricing/work_price.h"

#include <algorithm>

#include "server/sessions/field_bytes.h"
#include "stiefel/price.h"

namespace stiefel::server {

double recommendation_work(std::string_view system, std::uint32_t members, std::uint64_t columns) {
  return std::max<std::uint32_t>(members, 1) *
         substeps_work(system, static_cast<Eigen::Index>(columns));
}

double creation_work(double N, double members) {
  return members * (40 * N * N * N + 4000 * N * N + 1e4);
}

double conversion_work(double N, double members) { return members * (3000 * N * N * N + 1e5); }

double fork_work(const Session& from, bool converts) {
  const double N = whole_dimension(from.scene());
  const double members = std::max<double>(1, static_cast<double>(from.scene().members().size()));
  return creation_work(N, members) + (converts ? conversion_work(N, members) : 0);
}

double diagnosis_work(const Session& session, const DiagnosisSize& size) {
  // Matrix products for the norms, Casimirs and momenta of two states, for a form, and for a
  // bracket.
  constexpr double of_state = 200, of_form = 40, of_bracket = 250, steps_of_pair = 12;
  // N²/2 products in extended precision, of two states.
  constexpr double of_manakov = 15;
  // Jacobi's method for four matrices of two states.
  constexpr double of_singular_values = 1000;
  const double N = whole_dimension(session.scene()), product = N * N * N;
  double of_each = of_state * product;
  if (size.manakov) of_each += of_manakov * N * N * product;
  if (size.singular_values) of_each += of_singular_values * product;
  double work = of_each * std::max(1.0, static_cast<double>(session.scene().members().size()));
  work += static_cast<double>(size.forms) * of_form * product;
  for (const std::size_t factors : size.factors)
    work += of_bracket * product + static_cast<double>(factors) * 6 * N * N;
  if (size.pairs > 0) work += steps_of_pair * size.pairs * session.work(0, 1);
  return work + size.estimate_work;
}

}  // namespace stiefel::server
