#include "server/convert/diagnose_task.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "engine/numbers/to_text.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "stiefel/error_estimate.h"

namespace stiefel::server {
namespace {

static_assert(same_order(BodyMotion::Kind::separatrix, v1::MOTION_KIND_AT_REST) ==
              v1::MOTION_KIND_SEPARATRIX);

/// Returns the value of the element at `path`, which must be finite.
double number(const std::string& path, std::expected<double, Violations> computed) {
  const double value = value_of(std::move(computed), Place::inside(path));
  if (!std::isfinite(value))
    throw errors::invalid(path, to_text(value), "overflows: its arguments are too large");
  return value;
}

std::string family_of(const std::string& invariant) {
  return invariant.substr(0, invariant.find('['));
}

/// Keeps, of each family, the `most` invariants with the largest drifts, in their order: every
/// family of every N <= 91 whole.
void shorten(std::vector<InvariantDrift>& invariants, v1::DiagnoseResponse* response) {
  constexpr std::size_t most = 4096;
  std::map<std::string, std::vector<double>> drifts;
  for (const InvariantDrift& invariant : invariants)
    drifts[family_of(invariant.name)].push_back(-invariant.drift());
  for (auto& [family, values] : drifts) {
    if (values.size() <= most) continue;
    auto* shortened = response->add_shortened();
    shortened->set_name(family);
    shortened->set_count(values.size());
    std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(most) - 1);
    const double least = -values[most - 1];
    std::size_t kept = 0;
    std::erase_if(invariants, [&](const InvariantDrift& invariant) {
      return family_of(invariant.name) == family && (invariant.drift() < least || kept++ >= most);
    });
  }
}

void put(const BodyMotion& motion, v1::BodyMotion* out) {
  out->set_kind(same_order(motion.kind, v1::MOTION_KIND_AT_REST));
  out->set_separatrix(motion.separatrix);
  if (motion.period) out->set_period(*motion.period);
  if (motion.precession_period) out->set_precession_period(*motion.precession_period);
  out->set_least_nutation(motion.nutation[0]);
  out->set_largest_nutation(motion.nutation[1]);
  out->set_energy(motion.energy);
  for (int i = 0; i < 3; ++i) {
    out->add_momentum(motion.momentum(i));
    out->add_moments(motion.moments(i));
    for (int j = 0; j < 3; ++j) out->add_axes(motion.axes(i, j));
  }
}

void put(const Diagnosis& diagnosis, v1::DiagnoseResponse* out) {
  for (const InvariantDrift& drift : diagnosis.invariants) {
    auto* to = out->add_invariants();
    to->set_name(drift.name);
    to->set_initial(static_cast<double>(drift.initial));
    to->set_value(static_cast<double>(drift.value));
    to->set_drift(drift.drift());
    to->set_scale(static_cast<double>(drift.scale));
    to->set_conservation(same_order(drift.conservation, v1::CONSERVATION_EXACT));
    if (drift.member) to->set_member(static_cast<std::uint32_t>(*drift.member));
  }
  if (diagnosis.orthogonality) out->set_orthogonality(*diagnosis.orthogonality);
  out->mutable_domain()->set_h_omega(diagnosis.h_omega);
  if (diagnosis.largest_step) out->mutable_domain()->set_largest_step(*diagnosis.largest_step);
  if (diagnosis.motion) put(*diagnosis.motion, out->mutable_motion());
}

/// Whether no number computed from the state is NaN.
bool has_no_nan(const v1::DiagnoseResponse& reply) {
  const auto is_number = [](double value) { return !std::isnan(value); };
  return is_number(reply.orthogonality()) && is_number(reply.domain().h_omega()) &&
         is_number(reply.estimated_error().attitude()) &&
         is_number(reply.estimated_error().momentum()) &&
         std::ranges::all_of(reply.invariants(), [&](const v1::Invariant& one) {
           return is_number(one.initial()) && is_number(one.value()) && is_number(one.drift()) &&
                  is_number(one.scale());
         });
}

void put(const ErrorEstimate& estimate, v1::EstimatedError* out) {
  if (estimate.attitude) out->set_attitude(*estimate.attitude);
  if (estimate.momentum) out->set_momentum(*estimate.momentum);
  if (estimate.angle) out->set_angle(*estimate.angle);
  out->set_reference_error(estimate.reference_error);
  out->set_reference(estimate.reference);
  out->set_work(estimate.work);
  out->set_run_work(estimate.run_work);
  out->set_missing(estimate.missing);
  if (estimate.member) out->set_member(static_cast<std::uint32_t>(*estimate.member));
}

}  // namespace

void answer(const DiagnoseTask& task, const Session& session, const Cursor& cursor,
            const std::stop_token& stop, v1::DiagnoseResponse* response) {
  const Scene& scene = session.scene();
  const Simulation& now = cursor.simulation();
  to_proto(cursor, scene, response->mutable_run_status());
  response->set_step(cursor.step());
  response->set_time(scene.time(cursor.step()));
  response->set_computed_steps(cursor.computed_steps());
  Diagnosis diagnosis = diagnose(scene, now, task.invariants, stop);
  shorten(diagnosis.invariants, response);
  put(diagnosis, response);
  for (std::size_t i = 0; i < task.forms.size() && !stop.stop_requested(); ++i) {
    const auto& [name, first, second] = task.forms[i];
    const std::string path = Path("forms", i).text();
    response->add_forms(number(path, evaluate_form(scene, now, name, first, second)));
  }
  for (std::size_t i = 0; i < task.brackets.size() && !stop.stop_requested(); ++i) {
    const auto& [first, second] = task.brackets[i];
    const std::string path = Path("dirac_brackets", i).text();
    response->add_dirac_brackets(number(path, dirac_bracket(scene, now, first, second)));
  }
  if (task.symplectic) {
    const auto defect =
        value_of(symplectic_defect(scene, now, static_cast<int>(task.symplectic->pairs()),
                                   task.symplectic->seed(), stop),
                 Place::inside("symplectic_test"));
    if (defect) response->set_symplectic_defect(*defect);
  }
  if (task.estimate_error != v1::ERROR_ESTIMATION_UNSPECIFIED) {
    // In instructions: about ten seconds, and the ten milliseconds that are cheap for any run.
    constexpr double most = 5e10, small = 5e7;
    const double budget = task.estimate_error == v1::ERROR_ESTIMATION_IF_CHEAPER
                              ? std::clamp(run_work(scene, now), small, most)
                              : most;
    put(estimate_error(scene, now, budget, stop), response->mutable_estimated_error());
  }
  demand_finite(has_no_nan(*response), response->mutable_run_status());
}

}  // namespace stiefel::server
