#include "stiefel/diagnosis.h"

#include "server/convert/convert.h"
#include "stiefel/error_estimate.h"

namespace stiefel::server {

void to_proto(const Diagnosis& diagnosis, v1::DiagnoseResponse* out) {
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
}

void to_proto(const ErrorEstimate& estimate, v1::EstimatedError* out) {
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

}  // namespace stiefel::server
