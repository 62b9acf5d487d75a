#include <limits>

#include "server/service/convert.h"

namespace stiefel::server {
namespace {

std::vector<double> numbers(const google::protobuf::RepeatedField<double>& values) {
  return {values.begin(), values.end()};
}

void read_matrix(const std::string& path, const v1::Matrix& matrix, RowMatrix& out,
                 Violations& violations) {
  const auto check = [&](const char* name, std::uint32_t value) {
    if (value >= 1 && value <= Scene::max_dimension) return true;
    violations.push_back({path + "." + name, std::to_string(value),
                          "must be 1 to " + std::to_string(Scene::max_dimension)});
    return false;
  };
  const bool rows = check("rows", matrix.rows());
  const bool cols = check("cols", matrix.cols());
  if (!rows || !cols) return;
  const std::uint64_t size = std::uint64_t{matrix.rows()} * matrix.cols();
  if (static_cast<std::uint64_t>(matrix.values_size()) != size) {
    violations.push_back({path + ".values", std::to_string(matrix.values_size()) + " values",
                          "must be rows * cols = " + std::to_string(size)});
    return;
  }
  out = Eigen::Map<const RowMatrix>(matrix.values().data(), matrix.rows(), matrix.cols());
}

void read_count(const std::string& path, std::uint32_t value, std::optional<int>& out,
                Violations& violations) {
  if (value > static_cast<std::uint32_t>(std::numeric_limits<int>::max())) {
    violations.push_back({path, std::to_string(value), "is too large"});
  } else {
    out = static_cast<int>(value);
  }
}

MethodDescription read_method(const v1::Method& method, Violations& violations) {
  MethodDescription out;
  out.name = method.name();
  out.arithmetic = method.arithmetic();
  if (method.has_order()) read_count("method.order", method.order(), out.order, violations);
  if (method.has_substeps()) {
    read_count("method.substeps", method.substeps(), out.substeps, violations);
  }
  return out;
}

}  // namespace

std::expected<SceneDescription, Violations> from_proto(const v1::Scene& scene) {
  SceneDescription out;
  Violations violations;
  out.system = scene.system();
  if (scene.has_method()) out.method = read_method(scene.method(), violations);
  out.inertia = numbers(scene.inertia());
  for (const auto& [name, matrix] : scene.initial()) {
    read_matrix("initial." + name, matrix, out.initial[name], violations);
  }
  if (scene.has_body()) {
    out.body =
        BodyDescription{numbers(scene.body().inertia_tensor()), numbers(scene.body().moments()),
                        numbers(scene.body().attitude()), numbers(scene.body().angular_velocity())};
  }
  out.step = scene.step();
  if (!violations.empty()) return std::unexpected(std::move(violations));
  return out;
}

void to_proto(const SceneDescription& description, v1::Scene* out) {
  out->set_system(description.system);
  if (const auto& method = description.method) {
    auto* to = out->mutable_method();
    to->set_name(method->name);
    if (method->order) to->set_order(static_cast<std::uint32_t>(*method->order));
    if (method->substeps) to->set_substeps(static_cast<std::uint32_t>(*method->substeps));
    to->set_arithmetic(method->arithmetic);
  }
  out->mutable_inertia()->Add(description.inertia.begin(), description.inertia.end());
  for (const auto& [name, block] : description.initial) {
    v1::Matrix& to = (*out->mutable_initial())[name];
    to.set_rows(static_cast<std::uint32_t>(block.rows()));
    to.set_cols(static_cast<std::uint32_t>(block.cols()));
    to.mutable_values()->Add(block.data(), block.data() + block.size());
  }
  if (const auto& body = description.body) {
    auto* to = out->mutable_body();
    to->mutable_inertia_tensor()->Add(body->inertia_tensor.begin(), body->inertia_tensor.end());
    to->mutable_moments()->Add(body->moments.begin(), body->moments.end());
    to->mutable_attitude()->Add(body->attitude.begin(), body->attitude.end());
    to->mutable_angular_velocity()->Add(body->angular_velocity.begin(),
                                        body->angular_velocity.end());
  }
  out->set_step(description.step);
}

}  // namespace stiefel::server
