#include "server/convert/geodesics/geodesic_answers.h"

#include <algorithm>
#include <utility>

#include "engine/numbers/to_text.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

constexpr std::uint32_t max_restarts = 1000;
constexpr int max_pairs = 1024;

std::string path_of(std::size_t pair, const std::string& field) {
  const bool of_pair = field == "Q_0" || field == "Q_T";
  return of_pair ? "pairs[" + std::to_string(pair) + "]." + field : field;
}

class ConnectReader {
 public:
  explicit ConnectReader(const v1::ConnectRequest& request) : request_(request) {}

  OrStatus<ConnectTask> read() {
    check_limits();
    TwoPointProblem common;
    common.time = request_.time();
    common.seed = request_.seed();
    if (request_.has_restarts())
      common.restarts = static_cast<int>(std::min(request_.restarts(), max_restarts));
    if (request_.metric() == v1::METRIC_CANONICAL) common.beta = 0.5;
    if (request_.metric() == v1::METRIC_BETA) common.beta = request_.beta();
    ConnectTask task{{},
                     static_cast<int>(request_.steps()),
                     static_cast<int>(request_.samples()),
                     request_.view() != v1::GEODESIC_VIEW_VELOCITY};
    for (int i = 0; i < std::min(request_.pairs_size(), max_pairs); ++i) {
      stop_point();
      TwoPointProblem one = problem(i, common);
      if (faults_.empty()) task.problems.push_back(std::move(one));
    }
    if (!faults_.empty()) return std::unexpected(errors::invalid(faults_.take()));
    return task;
  }

 private:
  void refuse(std::string field, std::string value, std::string rule) {
    faults_.add(field, std::move(value), std::move(rule));
  }
  void at_most(const char* field, std::uint64_t value, std::uint64_t most) {
    if (value > most)
      refuse(field, std::to_string(value), "must be at most " + std::to_string(most));
  }
  void check_limits() {
    at_most("steps", request_.steps(), max_connect_steps);
    at_most("samples", request_.samples(), max_connect_samples);
    at_most("restarts", request_.restarts(), max_restarts);
    if (request_.pairs_size() < 1 || request_.pairs_size() > max_pairs)
      refuse("pairs", std::to_string(request_.pairs_size()) + " pairs",
             "must be 1 to " + std::to_string(max_pairs));
    const v1::Metric metric = request_.metric();
    if (!v1::Metric_IsValid(metric))
      return refuse("metric", std::to_string(metric), "must be a value of stiefel.v1.Metric");
    const bool has_inertia = metric == v1::METRIC_LAMBDA || metric == v1::METRIC_UNSPECIFIED;
    if (!has_inertia && request_.inertia_size() > 0)
      refuse("inertia", std::to_string(request_.inertia_size()) + " numbers",
             "must be absent with " + v1::Metric_Name(metric));
    if (request_.has_beta() != (metric == v1::METRIC_BETA))
      refuse("beta", request_.has_beta() ? to_text(request_.beta()) : "absent",
             request_.has_beta() ? "must be absent without METRIC_BETA" : "must be given");
    if (!v1::GeodesicView_IsValid(request_.view()))
      refuse("view", std::to_string(request_.view()), "must be a value of stiefel.v1.GeodesicView");
  }

  Eigen::MatrixXd frame(const Path& pair, const char* name, const v1::Matrix* matrix,
                        const v1::Tensor* tensor) {
    const std::string tensor_name = std::string(name) + "_tensor";
    const Path path(pair, name), tensor_path(pair, tensor_name.c_str());
    if (matrix && tensor) {
      faults_.add(tensor_path, "given", std::string("must be absent where ") + name + " is given");
    } else if (tensor) {
      Block block;
      read_block(tensor_path, *tensor, block, faults_);
      if (tensor->shape_size() != 2 || block.imaginary.size() > 0)
        faults_.add(tensor_path, std::to_string(tensor->shape_size()) + " axes",
                    "must be real numbers of shape (n, N)");
      return std::move(block.values);
    } else if (matrix) {
      if (auto read = read_matrix(path, *matrix, faults_)) return *std::move(read);
    } else {
      faults_.add(path, "absent", "must be given");
    }
    return {};
  }

  TwoPointProblem problem(int index, TwoPointProblem out) {
    const v1::FramePair& given = request_.pairs(index);
    const Path pairs("pairs"), pair(pairs, index);
    out.Q_0 = frame(pair, "Q_0", given.has_q_0() ? &given.q_0() : nullptr,
                    given.has_q_0_tensor() ? &given.q_0_tensor() : nullptr);
    out.Q_T = frame(pair, "Q_T", given.has_q_t() ? &given.q_t() : nullptr,
                    given.has_q_t_tensor() ? &given.q_t_tensor() : nullptr);
    if (shape_.empty()) shape_ = shape_of(out.Q_0);
    if (const std::string shape = shape_of(out.Q_0); shape != shape_ && !shape.empty())
      faults_.add(Path(pair, "Q_0"), shape, "must have the shape of the first frame, " + shape_);
    if (request_.metric() == v1::METRIC_EUCLIDEAN)
      out.inertia = Eigen::VectorXd::Ones(out.Q_0.cols());
    else if (!out.beta)
      out.inertia =
          Eigen::Map<const Eigen::VectorXd>(request_.inertia().data(), request_.inertia_size());
    return out;
  }

  /// Empty for a frame that was refused.
  static std::string shape_of(const Eigen::MatrixXd& Q) {
    return Q.size() == 0 ? "" : std::to_string(Q.rows()) + " x " + std::to_string(Q.cols());
  }

  const v1::ConnectRequest& request_;
  std::string shape_;  // of the first frame
  Faults faults_{in_the_request};
};

}  // namespace

std::optional<grpc::Status> refused(const ConnectRefusal& refusal, std::size_t pair) {
  if (const auto* invalid = std::get_if<refusal::Invalid>(&refusal))
    return errors::invalid(path_of(pair, invalid->field), invalid->value, invalid->rule);
  if (const auto* frame = std::get_if<refusal::NotOrthonormal>(&refusal))
    return errors::invalid(path_of(pair, frame->field), "max |QQᵀ − I| = " + to_text(frame->defect),
                           "must have orthonormal rows to " + to_text(Scene::frame_tolerance));
  if (const auto* signs = std::get_if<refusal::UnequalDeterminants>(&refusal))
    return errors::unequal_determinants(path_of(pair, "Q_T"), signs->Q_0, signs->Q_T);
  return std::nullopt;
}

OrStatus<ConnectTask> read(const v1::ConnectRequest& request) {
  auto task = ConnectReader(request).read();
  if (!task) return task;
  for (std::size_t i = 0; i < task->problems.size(); ++i) {
    stop_point();
    const auto refusal = refusal_of(task->problems[i]);
    if (const auto status = refusal ? refused(*refusal, i) : std::nullopt)
      return std::unexpected(*status);
  }
  return *std::move(task);
}

}  // namespace stiefel::server
