#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "engine/linalg/arithmetic/to_text.h"
#include "server/convert/checks/door.h"
#include "server/convert/convert.h"
#include "server/convert/diagnosis/parts.h"
#include "server/convert/errors.h"
#include "server/convert/price.h"
#include "stiefel/diagnosis.h"
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

void estimate(const Scene& scene, const Simulation& now, v1::ErrorEstimation asked,
              const std::stop_token& stop, v1::EstimatedError* out) {
  const double budget =
      asked == v1::ERROR_ESTIMATION_IF_CHEAPER
          ? std::clamp(run_work(scene, now), small_estimate_work, most_estimate_work)
          : most_estimate_work;
  to_proto(estimate_error(scene, now, budget, stop), out);
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

}  // namespace

grpc::Status DiagnoseTask::answer(const Session& session, const Cursor& cursor,
                                  std::uint64_t memory, const std::stop_token& stop,
                                  v1::DiagnoseResponse* response) const {
  const Parts& task = *parts_;
  const Scene& scene = session.scene();
  const Simulation& now = cursor.simulation();
  to_proto(cursor, scene, response->mutable_run_status());
  response->set_step(cursor.step());
  response->set_time(scene.time(cursor.step()));
  response->set_computed_steps(cursor.computed_steps());
  to_proto(session.most_work(cursor.start(), cursor.step()) + work(session), 0,
           bound_of_steps(session), session.simulation_bytes() + memory, response->mutable_price());
  Diagnosis diagnosis = diagnose(scene, now, task.invariants, stop);
  shorten(task.max_invariants, diagnosis.invariants, response);
  to_proto(diagnosis, response);
  for (std::size_t i = 0; i < task.forms.size() && !stop.stop_requested(); ++i) {
    const auto& [name, first, second] = task.forms[i];
    const std::string path = indexed("forms", i);
    const auto value =
        number(path, evaluate_form(scene, now, name, first, second, Place::inside(path)));
    if (!value) return value.error();
    response->add_forms(*value);
  }
  for (std::size_t i = 0; i < task.brackets.size() && !stop.stop_requested(); ++i) {
    const auto& [first, second] = task.brackets[i];
    const std::string path = indexed("dirac_brackets", i);
    const auto value = number(path, dirac_bracket(scene, now, first, second, Place::inside(path)));
    if (!value) return value.error();
    response->add_dirac_brackets(*value);
  }
  if (task.symplectic) {
    const auto defect =
        symplectic_defect(scene, now, static_cast<int>(task.symplectic->pairs()),
                          task.symplectic->seed(), Place::inside("symplectic_test"), stop);
    if (!defect) return errors::invalid(defect.error());
    if (*defect) response->set_symplectic_defect(**defect);
  }
  if (task.estimates_error())
    estimate(scene, now, task.estimate_error, stop, response->mutable_estimated_error());
  check_at_the_door(is_finite(*response), response->mutable_run_status());
  return grpc::Status::OK;
}

}  // namespace stiefel::server
