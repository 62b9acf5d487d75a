#include "stiefel/connect.h"
#include "engine/linalg/arithmetic/to_text.h"
#include "server/calls/cursor_call.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/requests.h"

namespace stiefel::server {
namespace {

constexpr Eigen::Index max_degrees_of_freedom = 128;
constexpr std::uint32_t max_steps = 4096, max_restarts = 1000;
constexpr std::uint32_t max_samples = 100'000;

v1::Shortest shortest(Shortest value) {
  switch (value) {
    case Shortest::yes:
      return v1::SHORTEST_YES;
    case Shortest::no:
      return v1::SHORTEST_NO;
    case Shortest::unknown:
      return v1::SHORTEST_UNKNOWN;
  }
  return v1::SHORTEST_UNSPECIFIED;
}

struct Frames {
  TwoPointProblem problem;
  Violations violations;

  Eigen::MatrixXd frame(const char* field, bool present, const v1::Matrix& given) {
    if (!present) {
      violations.push_back({field, "absent", "must be given"});
      return {};
    }
    auto block = from_proto(field, given);
    if (!block) violations.insert(violations.end(), block.error().begin(), block.error().end());
    return block ? Eigen::MatrixXd(block->values) : Eigen::MatrixXd();
  }
  void at_most(const char* field, std::uint64_t value, std::uint64_t most) {
    if (value > most)
      violations.push_back(
          {field, std::to_string(value), "must be at most " + std::to_string(most)});
  }
};

Frames read(const v1::ConnectRequest& request) {
  Frames out;
  TwoPointProblem& problem = out.problem;
  problem.inertia =
      Eigen::Map<const Eigen::VectorXd>(request.inertia().data(), request.inertia_size());
  problem.Q_0 = out.frame("Q_0", request.has_q_0(), request.q_0());
  problem.Q_T = out.frame("Q_T", request.has_q_t(), request.q_t());
  problem.time = request.time();
  problem.seed = request.seed();
  if (request.has_restarts())
    problem.restarts = static_cast<int>(std::min(request.restarts(), max_restarts));
  out.at_most("steps", request.steps(), max_steps);
  out.at_most("samples", request.samples(), max_samples);
  out.at_most("restarts", request.restarts(), max_restarts);
  const Eigen::Index n = problem.Q_0.rows(), N = problem.Q_0.cols();
  if (n <= N && n * N - n * (n + 1) / 2 > max_degrees_of_freedom)
    out.violations.push_back({"Q_0", std::to_string(n) + " x " + std::to_string(N),
                              "frames must have at most 128 degrees of freedom, n N - n (n+1)/2"});
  return out;
}

/// A refusal is an error, but for a search that did not succeed.
grpc::Status refused(const ConnectRefusal& refusal, bool stopping, v1::ConnectResponse* response) {
  if (const auto* invalid = std::get_if<refusal::Invalid>(&refusal))
    return errors::invalid(invalid->field, invalid->value, invalid->rule);
  if (const auto* frame = std::get_if<refusal::NotOrthonormal>(&refusal))
    return errors::invalid(
        frame->field, "max |QQᵀ − I| = " + to_text(frame->defect),
        "must have orthonormal rows to " + to_text(TwoPointProblem::frame_tolerance));
  if (const auto* signs = std::get_if<refusal::UnequalDeterminants>(&refusal))
    return errors::unequal_determinants(signs->Q_0, signs->Q_T);
  RunStatus run_status{Outcome::cancelled, std::nullopt};
  if (const auto* missed = std::get_if<refusal::NotConverged>(&refusal)) {
    run_status.outcome = Outcome::solver_stalled;
    response->set_residual(missed->residual);
  } else if (!stopping) {
    return errors::cancelled();
  }
  to_proto(run_status, response->mutable_run_status());
  return grpc::Status::OK;
}

void write(const std::vector<Eigen::MatrixXd>& frames, v1::Tensor* out) {
  out->set_data_type(v1::DATA_TYPE_FLOAT64);
  out->add_shape(frames.size());
  out->add_shape(static_cast<std::uint64_t>(frames[0].rows()));
  out->add_shape(static_cast<std::uint64_t>(frames[0].cols()));
  for (const RowMatrix frame : frames)
    out->mutable_data()->append(reinterpret_cast<const char*>(frame.data()),
                                static_cast<std::size_t>(frame.size()) * sizeof(double));
}

}  // namespace

grpc::ServerUnaryReactor* Service::Connect(Context* context, const v1::ConnectRequest* request,
                                           v1::ConnectResponse* response) {
  const auto work = [this, request, response](const std::stop_token& stop) {
    if (host_.lifecycle.refusing()) return errors::shutting_down();
    auto [problem, violations] = read(*request);
    if (!violations.empty()) return errors::invalid(violations);
    problem.stop = stop;
    const auto joined = joining_scene(problem, static_cast<int>(request->steps()),
                                      static_cast<int>(request->samples()));
    if (!joined) return refused(joined.error(), host_.lifecycle.stopping(), response);
    to_proto(RunStatus{}, response->mutable_run_status());
    to_proto(joined->scene.description(), response->mutable_scene());
    response->set_energy(joined->energy);
    response->set_residual(joined->residual);
    response->set_shortest(shortest(joined->shortest));
    response->set_distinct(static_cast<std::uint32_t>(joined->distinct));
    if (!joined->trajectory.empty()) write(joined->trajectory, response->mutable_trajectory());
    return grpc::Status::OK;
  };
  return new PooledCall(host_, host_.searches, CallLog(host_.log, *context, "Connect"), work);
}

}  // namespace stiefel::server
