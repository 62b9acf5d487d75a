#include "server/convert/geodesics/geodesic_answers.h"

#include "engine/numbers/to_text.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

constexpr std::uint32_t max_steps = 4096, max_samples = 100'000, max_restarts = 1000;
constexpr int max_pairs = 1024;

std::string path_of(std::size_t pair, const std::string& field) {
  const bool of_pair = field == "Q_0" || field == "Q_T";
  return of_pair ? "pairs[" + std::to_string(pair) + "]." + field : field;
}

void check_metric(const v1::ConnectRequest& request, Faults& faults) {
  const v1::Metric metric = request.metric();
  if (!v1::Metric_IsValid(metric))
    return faults.add("metric", std::to_string(metric), "must be a value of stiefel.v1.Metric");
  const bool has_inertia = metric == v1::METRIC_LAMBDA || metric == v1::METRIC_UNSPECIFIED;
  if (!has_inertia && request.inertia_size() > 0)
    faults.add("inertia", std::to_string(request.inertia_size()) + " numbers",
               "must be absent with " + v1::Metric_Name(metric));
  if (request.has_beta() != (metric == v1::METRIC_BETA))
    faults.add("beta", request.has_beta() ? to_text(request.beta()) : "absent",
               request.has_beta() ? "must be absent without METRIC_BETA" : "must be given");
}

/// Empty for a frame that was refused.
std::string shape_of(const Eigen::MatrixXd& Q) {
  return Q.size() == 0 ? "" : std::to_string(Q.rows()) + " x " + std::to_string(Q.cols());
}

/// Reads what all pairs have in common.
TwoPointProblem common(const v1::ConnectRequest& request) {
  TwoPointProblem out;
  out.time = request.time();
  out.seed = request.seed();
  if (request.has_budget())
    out.most_work = std::min(out.most_work, request.budget() * out.operations_per_second);
  if (request.has_restarts()) out.restarts = static_cast<int>(request.restarts());
  if (request.metric() == v1::METRIC_CANONICAL) out.beta = 0.5;
  if (request.metric() == v1::METRIC_BETA) out.beta = request.beta();
  return out;
}

}  // namespace

void throw_refused(const ConnectRefusal& refusal, std::size_t pair) {
  if (std::holds_alternative<refusal::Cancelled>(refusal)) throw Stopped();
  if (const auto* invalid = std::get_if<refusal::Invalid>(&refusal))
    throw errors::invalid(path_of(pair, invalid->field), invalid->value, invalid->rule);
  if (const auto* frame = std::get_if<refusal::NotOrthonormal>(&refusal))
    throw errors::invalid(path_of(pair, frame->field), "max |QQᵀ − I| = " + to_text(frame->defect),
                          "must have orthonormal rows to " + to_text(Scene::frame_tolerance));
  if (const auto* signs = std::get_if<refusal::UnequalDeterminants>(&refusal))
    throw errors::unequal_determinants(path_of(pair, "Q_T"), signs->Q_0, signs->Q_T);
}

ConnectTask read(const v1::ConnectRequest& request) {
  Faults faults(in_the_request);
  faults.at_most("steps", request.steps(), max_steps);
  faults.at_most("samples", request.samples(), max_samples);
  faults.at_most("restarts", request.restarts(), max_restarts);
  if (request.pairs_size() < 1 || request.pairs_size() > max_pairs)
    faults.add("pairs", std::to_string(request.pairs_size()) + " pairs",
               "must be 1 to " + std::to_string(max_pairs));
  check_metric(request, faults);
  if (request.has_budget() && !(request.budget() > 0))
    faults.add("budget", to_text(request.budget()), "must be above 0");
  if (request.has_budget() && request.steps() > 0)
    faults.add("budget", to_text(request.budget()), "must be absent with steps");
  check(faults);
  ConnectTask task{std::vector(static_cast<std::size_t>(request.pairs_size()), common(request)),
                   static_cast<int>(request.steps()), static_cast<int>(request.samples()),
                   request.return_scene()};
  const Path pairs("pairs");
  std::string first_shape;
  for (int i = 0; i < request.pairs_size(); ++i) {
    stop_point();
    const v1::FramePair& given = request.pairs(i);
    TwoPointProblem& problem = task.problems[static_cast<std::size_t>(i)];
    const Path pair(pairs, i);
    problem.Q_0 = read_given(Path(pair, "Q_0"), given.has_q_0(), given.q_0(), faults);
    problem.Q_T = read_given(Path(pair, "Q_T"), given.has_q_t(), given.q_t(), faults);
    const std::string shape = shape_of(problem.Q_0);
    if (first_shape.empty()) first_shape = shape;
    if (shape != first_shape && !shape.empty())
      faults.add(Path(pair, "Q_0"), shape,
                 "must have the shape of the first frame, " + first_shape);
    if (request.metric() == v1::METRIC_EUCLIDEAN)
      problem.inertia = Eigen::VectorXd::Ones(problem.Q_0.cols());
    else if (!problem.beta)
      problem.inertia =
          Eigen::Map<const Eigen::VectorXd>(request.inertia().data(), request.inertia_size());
  }
  check(faults);
  for (std::size_t i = 0; i < task.problems.size(); ++i) {
    stop_point();
    if (const auto refusal = refusal_of(task.problems[i])) throw_refused(*refusal, i);
  }
  return task;
}

}  // namespace stiefel::server
