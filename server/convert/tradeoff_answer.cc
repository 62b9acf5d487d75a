#include "server/convert/answers.h"

#include "server/convert/convert.h"
#include "server/sessions/identity.h"

namespace stiefel::server {

TradeoffRequest read(const v1::MeasureTradeoffRequest& request) {
  if (!request.has_scene()) throw errors::invalid("scene", "absent", "must be given");
  const Place place = Place::inside("scene");
  TradeoffRequest out{from_proto(request.scene(), place)};
  if (request.has_horizon()) out.horizon = request.horizon();
  if (request.has_budget()) out.budget = request.budget();
  if (request.has_repeats()) out.repeats = request.repeats();
  return out;
}

void to_proto(const TradeoffSetup& setup, v1::TradeoffSetup* out) {
  out->set_machine(setup.machine);
  out->set_numerics_id(numerics_id());
  out->set_reference(setup.reference);
  out->set_reference_error(setup.reference_error);
  out->set_horizon(setup.horizon);
  out->set_steps(setup.steps);
  out->set_reference_steps(setup.reference_steps);
  out->set_budget(setup.budget);
  out->set_repeats(static_cast<std::uint32_t>(setup.repeats));
  out->set_curves(static_cast<std::uint32_t>(setup.curves));
  out->mutable_warnings()->Add(setup.warnings.begin(), setup.warnings.end());
}

void to_proto(const TradeoffPoint& point, v1::TradeoffPoint* out) {
  to_proto(point.method, out->mutable_method());
  if (point.error) {
    if (point.error->attitude) out->set_attitude_error(*point.error->attitude);
    out->set_momentum_error(point.error->momentum);
  }
  out->set_drift(point.drift);
  out->set_drift_of(point.drift_of);
  out->set_work(point.work);
  out->mutable_cpu_seconds_per_second()->Add(point.cpu_seconds_per_second.begin(),
                                             point.cpu_seconds_per_second.end());
  out->set_steps_per_second(point.steps_per_second);
  out->set_measured_steps(point.measured_steps);
  out->set_extrapolated(point.extrapolated);
  out->set_below_reference(point.below_reference);
  to_proto(point.status, out->mutable_run_status());
}

}  // namespace stiefel::server
