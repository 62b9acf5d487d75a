#include "stiefel/tradeoff.h"

#include <limits>
#include <utility>

#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/requests.h"

namespace stiefel::server {
namespace {

std::expected<TradeoffRequest, Violations> read(const v1::MeasureTradeoffRequest& request) {
  if (!request.has_scene())
    return std::unexpected(Violations{{"scene", "absent", "must be given"}});
  auto scene = from_proto(request.scene(), Place::inside("scene"));
  if (!scene) return std::unexpected(std::move(scene.error()));
  TradeoffRequest out{*std::move(scene)};
  if (request.has_horizon()) out.horizon = request.horizon();
  if (request.has_budget()) out.budget = request.budget();
  if (request.has_repeats()) out.repeats = request.repeats();
  return out;
}

void to_proto(const TradeoffSetup& setup, v1::TradeoffSetup* out) {
  out->set_machine(setup.machine);
  out->set_build(setup.build);
  out->set_reference(setup.reference);
  out->set_reference_error(setup.reference_error);
  out->set_horizon(setup.horizon);
  out->set_steps(setup.steps);
  out->set_reference_steps(setup.reference_steps);
  out->set_budget(setup.budget);
  out->set_repeats(static_cast<std::uint32_t>(setup.repeats));
  out->set_curves(static_cast<std::uint32_t>(setup.curves));
}

void to_proto(const TradeoffPoint& point, v1::TradeoffPoint* out) {
  server::to_proto(point.method, out->mutable_method());
  out->set_scalar(point.method.scalar);
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
  server::to_proto(point.status, out->mutable_run_status());
}

/// A part of the answer in each slice: the reference, a point, at last the front. While a part is
/// written nothing is computed, so the job is queued anew by OnWriteDone. Deletes itself.
class TradeoffCall final : public grpc::ServerWriteReactor<v1::MeasureTradeoffResponse>,
                           private Job {
 public:
  TradeoffCall(Host& host, CallLog log, const v1::MeasureTradeoffRequest& request)
      : host_(host),
        log_(std::move(log)),
        request_(request),
        shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
    host_.lifecycle.enter();
    host_.searches.submit(this);
  }

  void OnCancel() override { stop_.request_stop(); }
  void OnWriteDone(bool ok) override {
    if (!ok) stop_.request_stop();
    host_.searches.submit(this);
  }
  void OnDone() override {
    Host& host = host_;
    delete this;
    host.lifecycle.leave();
  }

 private:
  bool run_slice() noexcept override {
    try {
      const grpc::Status status = compute();
      if (stop_.stop_requested())
        end(host_.lifecycle.stopping() ? errors::shutting_down() : errors::cancelled());
      else if (!status.ok())
        end(status);
      else if (message_.has_front())
        end_with_front();
      else
        StartWrite(&message_);
    } catch (...) {
      end(errors::from_current_exception());
    }
    return false;
  }

  /// The next part.
  grpc::Status compute() {
    message_.Clear();
    if (!tradeoff_) return start();
    const auto point = tradeoff_->next(stop_.get_token());
    if (point) {
      to_proto(*point, message_.mutable_point());
    } else {
      auto* front = message_.mutable_front();
      for (const std::size_t i : tradeoff_->front())
        front->add_points(static_cast<std::uint32_t>(i));
    }
    return grpc::Status::OK;
  }

  grpc::Status start() {
    if (host_.lifecycle.refusing()) return errors::shutting_down();
    auto request = read(request_);
    if (!request) return errors::invalid(request.error());
    auto prepared = Tradeoff::prepare(*std::move(request));
    if (!prepared) return errors::invalid(prepared.error());
    tradeoff_.emplace(*std::move(prepared));
    const auto setup = tradeoff_->solve_reference(stop_.get_token());
    if (!setup) return errors::invalid(setup.error());
    to_proto(*setup, message_.mutable_setup());
    return grpc::Status::OK;
  }

  void end(const grpc::Status& status) {
    log_.finish(status);
    Finish(status);
  }
  void end_with_front() {
    log_.finish(grpc::Status::OK);
    StartWriteAndFinish(&message_, grpc::WriteOptions(), grpc::Status::OK);
  }

  Host& host_;
  CallLog log_;
  const v1::MeasureTradeoffRequest& request_;
  std::stop_source stop_;
  std::stop_callback<RequestStop> shutdown_;
  std::optional<Tradeoff> tradeoff_;
  v1::MeasureTradeoffResponse message_;
};

}  // namespace

grpc::ServerWriteReactor<v1::MeasureTradeoffResponse>* Service::MeasureTradeoff(
    Context* context, const v1::MeasureTradeoffRequest* request) {
  return new TradeoffCall(host_, CallLog(host_.log, *context, "MeasureTradeoff"), *request);
}

}  // namespace stiefel::server
