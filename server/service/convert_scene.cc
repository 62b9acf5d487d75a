#include <cstring>
#include <limits>

#include "server/service/convert.h"

namespace stiefel::server {
namespace {

std::vector<double> numbers(const google::protobuf::RepeatedField<double>& values) {
  return {values.begin(), values.end()};
}

void read_values(const std::string& path, const v1::Matrix& matrix,
                 const google::protobuf::RepeatedField<double>& values, RowMatrix& out,
                 Violations& violations) {
  const std::uint64_t size = std::uint64_t{matrix.rows()} * matrix.cols();
  if (static_cast<std::uint64_t>(values.size()) != size) {
    violations.push_back({path, std::to_string(values.size()) + " values",
                          "must be rows * cols = " + std::to_string(size)});
    return;
  }
  out = Eigen::Map<const RowMatrix>(values.data(), matrix.rows(), matrix.cols());
}

void read_block(const std::string& path, const v1::Matrix& matrix, Block& out,
                Violations& violations) {
  const auto check = [&](const char* name, std::uint32_t value) {
    if (value >= 1 && value <= Scene::max_elements) return true;
    violations.push_back({path + "." + name, std::to_string(value),
                          "must be 1 to " + std::to_string(Scene::max_elements)});
    return false;
  };
  const bool rows = check("rows", matrix.rows());
  const bool cols = check("cols", matrix.cols());
  if (!rows || !cols) return;
  if (std::uint64_t{matrix.rows()} * matrix.cols() > Scene::max_elements) {
    violations.push_back(
        {path, std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()),
         "must have at most " + std::to_string(Scene::max_elements) + " elements"});
    return;
  }
  read_values(path + ".values", matrix, matrix.values(), out.values, violations);
  if (matrix.imaginary_size() > 0)
    read_values(path + ".imaginary", matrix, matrix.imaginary(), out.imaginary, violations);
}

/// A tensor (rows, cols) or (members, rows, cols), its blocks on top of each other.
void read_tensor(const std::string& path, const v1::Tensor& tensor, Block& out,
                 Violations& violations) {
  const auto refuse = [&](const char* name, std::string value, std::string rule) {
    violations.push_back({path + "." + name, std::move(value), std::move(rule)});
  };
  const bool complex = tensor.data_type() == v1::DATA_TYPE_COMPLEX128;
  if (!complex && tensor.data_type() != v1::DATA_TYPE_FLOAT64)
    return refuse("data_type", v1::DataType_Name(tensor.data_type()),
                  "must be DATA_TYPE_FLOAT64 or DATA_TYPE_COMPLEX128");
  std::string shape;
  std::uint64_t size = 1;
  for (const auto extent : tensor.shape()) {
    shape += (shape.empty() ? "" : " x ") + std::to_string(extent);
    size = extent >= 1 && extent <= Scene::max_elements ? size * extent : 0;
    if (size > Scene::max_elements) size = 0;
  }
  if (size == 0 || tensor.shape_size() < 2 || tensor.shape_size() > 3)
    return refuse("shape", shape,
                  "must be (rows, cols) or (members, rows, cols), of 1 to " +
                      std::to_string(Scene::max_elements) + " elements");
  const std::uint64_t bytes = size * sizeof(double) * (complex ? 2 : 1);
  if (tensor.data().size() != bytes)
    return refuse("data", std::to_string(tensor.data().size()) + " bytes",
                  "must have " + std::to_string(bytes) + " for the shape " + shape);
  const auto cols = static_cast<Eigen::Index>(tensor.shape(tensor.shape_size() - 1));
  const auto rows = static_cast<Eigen::Index>(size) / cols;
  RowMatrix numbers(rows, complex ? 2 * cols : cols);
  std::memcpy(numbers.data(), tensor.data().data(), bytes);
  if (!complex) {
    out.values = std::move(numbers);
    return;
  }
  out.values = numbers(Eigen::all, Eigen::seqN(0, cols, 2));
  out.imaginary = numbers(Eigen::all, Eigen::seqN(1, cols, 2));
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
  if (method.has_tolerance()) out.tolerance = method.tolerance();
  out.scalar = method.scalar();
  return out;
}

}  // namespace

std::expected<Block, Violations> from_proto(const std::string& path, const v1::Matrix& matrix) {
  Block out;
  Violations violations;
  read_block(path, matrix, out, violations);
  if (!out.values.allFinite() || !out.imaginary.allFinite())
    violations.push_back({path, "infinite or not a number", "must be finite"});
  if (!violations.empty()) return std::unexpected(std::move(violations));
  return out;
}

void to_proto(const RowMatrix& values, v1::Matrix* out) {
  out->set_rows(static_cast<std::uint32_t>(values.rows()));
  out->set_cols(static_cast<std::uint32_t>(values.cols()));
  out->mutable_values()->Add(values.data(), values.data() + values.size());
}

std::expected<SceneDescription, Violations> from_proto(const v1::Scene& scene) {
  SceneDescription out;
  Violations violations;
  out.system = scene.system();
  if (scene.has_method()) out.method = read_method(scene.method(), violations);
  out.inertia = numbers(scene.inertia());
  out.inertia_u = numbers(scene.inertia_u());
  out.inertia_v = numbers(scene.inertia_v());
  if (scene.has_epsilon()) out.epsilon = scene.epsilon();
  if (scene.has_parameter()) out.parameter = scene.parameter();
  for (const auto& [name, matrix] : scene.initial()) {
    read_block("initial." + name, matrix, out.initial[name], violations);
  }
  for (const auto& [name, tensor] : scene.initial_tensors()) {
    if (scene.initial().contains(name))
      violations.push_back(
          {"initial_tensors." + name, "given", "must be absent: it is in initial"});
    else
      read_tensor("initial_tensors." + name, tensor, out.initial[name], violations);
  }
  if (scene.has_members()) {
    out.members.emplace();
    read_count("members", scene.members(), out.members, violations);
  }
  if (scene.has_body()) {
    out.body =
        BodyDescription{numbers(scene.body().inertia_tensor()), numbers(scene.body().moments()),
                        numbers(scene.body().attitude()), numbers(scene.body().angular_velocity())};
  }
  out.step = scene.step();
  if (scene.has_tolerance()) out.tolerance = scene.tolerance();
  if (scene.has_horizon()) out.horizon = scene.horizon();
  out.choice = scene.choice();
  if (!violations.empty()) return std::unexpected(std::move(violations));
  return out;
}

void to_proto(const MethodDescription& method, v1::Method* out) {
  out->set_name(method.name);
  if (method.order) out->set_order(static_cast<std::uint32_t>(*method.order));
  if (method.substeps) out->set_substeps(static_cast<std::uint32_t>(*method.substeps));
  out->set_arithmetic(method.arithmetic);
  if (method.tolerance) out->set_tolerance(*method.tolerance);
  out->set_scalar(method.scalar);
}

void to_proto(const SceneDescription& description, v1::Scene* out) {
  out->set_system(description.system);
  if (description.method) to_proto(*description.method, out->mutable_method());
  const auto add = [](const std::vector<double>& from, auto* to) {
    to->Add(from.begin(), from.end());
  };
  add(description.inertia, out->mutable_inertia());
  add(description.inertia_u, out->mutable_inertia_u());
  add(description.inertia_v, out->mutable_inertia_v());
  if (description.epsilon) out->set_epsilon(*description.epsilon);
  if (description.parameter) out->set_parameter(*description.parameter);
  for (const auto& [name, block] : description.initial) {
    v1::Matrix& to = (*out->mutable_initial())[name];
    const auto& [values, imaginary] = block;
    to_proto(values, &to);
    to.mutable_imaginary()->Add(imaginary.data(), imaginary.data() + imaginary.size());
  }
  if (const auto& body = description.body) {
    auto* to = out->mutable_body();
    add(body->inertia_tensor, to->mutable_inertia_tensor());
    add(body->moments, to->mutable_moments());
    add(body->attitude, to->mutable_attitude());
    add(body->angular_velocity, to->mutable_angular_velocity());
  }
  out->set_step(description.step);
  if (description.tolerance) out->set_tolerance(*description.tolerance);
  if (description.horizon) out->set_horizon(*description.horizon);
  out->set_choice(description.choice);
  if (description.members) out->set_members(static_cast<std::uint32_t>(*description.members));
}

}  // namespace stiefel::server
