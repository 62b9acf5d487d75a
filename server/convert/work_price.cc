#include "server/convert/work_price.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "server/scheduling/slice.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/connect.h"
#include "stiefel/conversion.h"
#include "stiefel/diagnosis.h"
#include "stiefel/invariant_names.h"
#include "stiefel/price.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {
namespace {

double members_of(const v1::Scene& scene) { return std::max<std::uint32_t>(scene.members(), 1); }
double members_of(const Session& session) {
  return std::max<double>(1, static_cast<double>(session.scene().members().size()));
}

/// Returns the largest number of columns of a block; a block without its numbers has none.
std::uint64_t columns(const v1::Scene& scene) {
  std::uint64_t largest = 0;
  const auto take = [&](std::uint64_t cols, std::uint64_t numbers) {
    largest = std::max(largest, std::min(cols, numbers));
  };
  for (const auto& [name, matrix] : scene.initial())
    take(matrix.cols(), static_cast<std::uint64_t>(matrix.values_size()));
  for (const auto& [name, tensor] : scene.initial_tensors())
    if (!tensor.shape().empty())
      take(*tensor.shape().rbegin(), tensor.data().size() / sizeof(double));
  return largest;
}

/// Returns the dimension of a scene, or p + q for complex p x q blocks; at least 3.
double dimension(const v1::Scene& scene) {
  const auto both = static_cast<double>(scene.inertia_u_size()) + scene.inertia_v_size();
  return std::max({both, static_cast<double>(columns(scene)), 3.0});
}

double of_creation(double N, double members) {
  return members * (40 * N * N * N + 4000 * N * N + 1e4);
}
double of_conversion(const std::string& to, double N) {
  return conversion_products(to) * N * N * N + 1e5;
}

/// Returns the predicted instructions of reading a field, or the invariants of that name, from one
/// state of all members. 0 for a name that is neither.
double reading_work(const Session& session, std::string_view name) {
  if (const auto index = find_field(session.fields(), name))
    return 4 * static_cast<double>(field_size(session.fields(), *index)) +
           field_work(session, *index);
  if (!is_invariant(session.scene(), name)) return 0;
  // Matrix products in extended precision: one for the energy, norms or Casimirs, N²/2 for all
  // Manakov coefficients, and Jacobi's method for the singular values.
  constexpr double of_product = 15, of_singular_values = 60, of_call = 500;
  const double N = whole_dimension(session.scene());
  double products = 1;
  if (name.starts_with(family::manakov)) products += N * N / 2;
  if (name.starts_with(family::singular_values)) products += of_singular_values;
  return members_of(session) * (products * of_product * N * N * N + of_call);
}

}  // namespace

double recommendation_work(const v1::Scene& scene) {
  if (scene.has_method() || scene.has_tolerance()) return 0;
  return members_of(scene) *
         substeps_work(scene.system(), static_cast<Eigen::Index>(columns(scene)));
}

double creation_work(const v1::Scene& scene) {
  return of_creation(dimension(scene), members_of(scene)) + recommendation_work(scene);
}

bool converts(const Session& from, const v1::ForkSessionRequest& request) {
  return request.has_system() && request.system() != from.scene().system();
}

double conversion_work(const v1::ConvertRequest& request) {
  return of_conversion(request.to(), dimension(request.scene()));
}

double fork_work(const Session& from, const v1::ForkSessionRequest& request) {
  const double N = whole_dimension(from.scene()), members = members_of(from);
  return of_creation(N, members) +
         (converts(from, request) ? of_conversion(request.system(), N) : 0);
}

double tradeoff_work(const v1::MeasureTradeoffRequest& request) {
  const double budget = request.has_budget() ? request.budget() : TradeoffRequest::default_budget;
  return std::isfinite(budget) ? std::max(budget, 0.0) : 0;
}

double connect_work(const v1::ConnectRequest& request) {
  return TwoPointProblem().most_work * request.pairs_size();
}

ReadingWork reading_work(const Session& session, const v1::SummarizeRequest& request) {
  const auto last_only = [](const v1::Quantity& quantity) {
    return quantity.quantiles().empty() && quantity.edges().empty() &&
           std::ranges::all_of(quantity.statistics(),
                               [](int asked) { return asked == v1::STATISTIC_LAST; });
  };
  double on_the_way = 0, once = 0;
  for (const v1::Quantity& quantity : request.quantities())
    (last_only(quantity) ? once : on_the_way) += reading_work(session, quantity.name());
  double at_events = 0;
  for (const v1::Event& event : request.events()) {
    double of_event = reading_work(session, event.field());
    for (const v1::LinearTerm& term : event.plus()) of_event += reading_work(session, term.field());
    // The derivative takes six states, each by a simulation that is made for it.
    constexpr double states = 6, of_making = 5e4;
    if (event.extremum())
      of_event += states * (of_event + session.work(0, 1) + of_making * members_of(session));
    at_events += of_event;
  }
  const auto steps = static_cast<double>(request.to() - request.from());
  const double samples =
      steps / static_cast<double>(std::max<std::int64_t>(request.every(), 1)) + 1;
  return {on_the_way + at_events, samples * on_the_way + steps * at_events + once};
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
  double work = of_each * members_of(session);
  work += static_cast<double>(size.forms) * of_form * product;
  for (const std::size_t factors : size.factors)
    work += of_bracket * product + static_cast<double>(factors) * 6 * N * N;
  if (size.pairs > 0) work += steps_of_pair * size.pairs * session.work(0, 1);
  return work + size.estimate_work;
}

}  // namespace stiefel::server
