#include "server/pricing/reading_price.h"

#include <algorithm>

#include "server/scheduling/slice.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/diagnosis.h"
#include "stiefel/invariant_names.h"

namespace stiefel::server {
namespace {

double members_of(const Session& session) {
  return std::max<double>(1, static_cast<double>(session.scene().members().size()));
}

}  // namespace

double reading_work(const Session& session, std::string_view name) {
  const auto found = std::ranges::find(session.fields(), name, &Field::name);
  if (found != session.fields().end())
    return 4 * static_cast<double>(found->size()) +
           field_work(session, static_cast<std::size_t>(found - session.fields().begin()));
  if (!is_invariant(session.scene(), name)) return 0;
  // Matrix products in extended precision: one for the energy, norms or Casimirs, N²/2 for all
  // Manakov coefficients, and Jacobi's method for the singular values.
  constexpr double of_product = 15, of_singular_values = 60, of_call = 500;
  const double N = whole_dimension(session.scene());
  double products = 1;
  if (name.starts_with(family::manakov)) products += N * N / 2;
  if (name.starts_with(family::singular_values)) products += of_singular_values;
  const double work = products * of_product * N * N * N + of_call;
  return members_of(session) * work;
}

JobKind kind_with(const Session& session, double work) {
  return std::max(session.step_kind().kind, kind_of_steps(work / instructions_a_nanosecond));
}

}  // namespace stiefel::server
