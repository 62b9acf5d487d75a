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

/// Returns the value if it is finite, otherwise an error for the element at `path`.
OrStatus<double> number(const std::string& path, std::expected<double, Violations> value) {
  if (!value) return std::unexpected(errors::invalid(value.error()));
  if (!std::isfinite(*value))
    return std::unexpected(
        errors::invalid(path, to_text(*value), "overflows: its arguments are too large"));
  return *value;
}

std::string family_of(const std::string& invariant) {
  return invariant.substr(0, invariant.find('['));
}

/// Keeps, of each family, the at most `most` invariants with the largest drifts, in their order.
void shorten(std::size_t most, std::vector<InvariantDrift>& invariants,
             v1::DiagnoseResponse* response) {
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

constexpr v1::MotionKind kinds[] = {v1::MOTION_KIND_AT_REST, v1::MOTION_KIND_STEADY,
                                    v1::MOTION_KIND_SHORT_AXIS, v1::MOTION_KIND_LONG_AXIS,
                                    v1::MOTION_KIND_SEPARATRIX};

void put(const BodyMotion& motion, v1::BodyMotion* out) {
  out->set_kind(kinds[static_cast<int>(motion.kind)]);
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

}  // namespace

void put(const Diagnosis& diagnosis, v1::DiagnoseResponse* out) {
  for (const InvariantDrift& drift : diagnosis.invariants) {
    auto* to = out->add_invariants();
    to->set_name(drift.name);
    to->set_initial(static_cast<double>(drift.initial));
    to->set_value(static_cast<double>(drift.value));
    to->set_drift(drift.drift());
    to->set_scale(static_cast<double>(drift.scale));
    to->set_conservation(to_proto(drift.conservation));
    if (drift.member) to->set_member(static_cast<std::uint32_t>(*drift.member));
  }
  if (diagnosis.orthogonality) out->set_orthogonality(*diagnosis.orthogonality);
  out->mutable_domain()->set_h_omega(diagnosis.h_omega);
  if (diagnosis.largest_step) out->mutable_domain()->set_largest_step(*diagnosis.largest_step);
  if (diagnosis.motion) put(*diagnosis.motion, out->mutable_motion());
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

void DiagnoseTask::estimate(const Scene& scene, const Simulation& now, const std::stop_token& stop,
                            v1::EstimatedError* out) const {
  // An estimate of at most so much work, about ten milliseconds, is cheap whatever the run takes.
  constexpr double small = 5e7;
  const double budget = estimate_error_ == v1::ERROR_ESTIMATION_IF_CHEAPER
                            ? std::clamp(run_work(scene, now), small, most_estimate_work)
                            : most_estimate_work;
  put(estimate_error(scene, now, budget, stop), out);
}

grpc::Status DiagnoseTask::answer(const Session& session, const Cursor& cursor,
                                  const std::stop_token& stop,
                                  v1::DiagnoseResponse* response) const {
  const Scene& scene = session.scene();
  const Simulation& now = cursor.simulation();
  to_proto(cursor, scene, response->mutable_run_status());
  response->set_step(cursor.step());
  response->set_time(scene.time(cursor.step()));
  response->set_computed_steps(cursor.computed_steps());
  Diagnosis diagnosis = diagnose(scene, now, invariants_, stop);
  shorten(max_invariants_, diagnosis.invariants, response);
  put(diagnosis, response);
  for (std::size_t i = 0; i < forms_.size() && !stop.stop_requested(); ++i) {
    const auto& [name, first, second] = forms_[i];
    const std::string path = Path("forms", i).text();
    const auto value =
        number(path, evaluate_form(scene, now, name, first, second, Place::inside(path)));
    if (!value) return value.error();
    response->add_forms(*value);
  }
  for (std::size_t i = 0; i < brackets_.size() && !stop.stop_requested(); ++i) {
    const auto& [first, second] = brackets_[i];
    const std::string path = Path("dirac_brackets", i).text();
    const auto value = number(path, dirac_bracket(scene, now, first, second, Place::inside(path)));
    if (!value) return value.error();
    response->add_dirac_brackets(*value);
  }
  if (symplectic_) {
    const auto defect =
        symplectic_defect(scene, now, static_cast<int>(symplectic_->pairs()), symplectic_->seed(),
                          Place::inside("symplectic_test"), stop);
    if (!defect) return errors::invalid(defect.error());
    if (*defect) response->set_symplectic_defect(**defect);
  }
  if (estimates_error()) estimate(scene, now, stop, response->mutable_estimated_error());
  demand_finite(is_finite(*response), response->mutable_run_status());
  return grpc::Status::OK;
}

}  // namespace stiefel::server
