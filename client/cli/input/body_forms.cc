#include "client/cli/input/body_forms.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "client/cli/exit_status.h"
#include "client/cli/input/nested_numbers.h"

namespace stiefel::cli {
namespace {

using Json = nlohmann::json;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Vectors = std::vector<Eigen::VectorXd>;

constexpr double exact = 1e-6;    ///< the largest distance from a rotation that the server takes
constexpr double rounded = 0.01;  ///< the largest change by `normalize`
constexpr double symmetric = 1e-10;

std::string shown(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

void check(const std::string& place, double change) {
  if (!(change <= rounded))
    throw BadInput(place + ": changes by " + shown(change) +
                   ": normalize changes a state by at most " + shown(rounded));
}

/// Whether a value is a 3 × 3 matrix, or a list of such.
bool is_matrix(const Json& given) {
  const auto holds_three = [](const Json& one) { return one.is_array() && one.size() == 3; };
  if (!given.is_array() || given.empty() || !given[0].is_array()) return false;
  const Json& one = !given[0].empty() && given[0][0].is_array() ? given[0] : given;
  return holds_three(one) && holds_three(one[0]) && holds_three(one[1]) && holds_three(one[2]);
}

/// Returns vectors of `width` numbers, one or as many as there are members.
Vectors vectors_of(const std::string& place, const Json& given, std::size_t width,
                   const char* rule) {
  const std::vector<double> numbers = numbers_of(place, given);
  if (numbers.empty() || numbers.size() % width != 0)
    throw BadInput(place + ": " + std::to_string(numbers.size()) + " numbers: must be " + rule);
  Vectors vectors;
  for (std::size_t i = 0; i < numbers.size(); i += width)
    vectors.push_back(
        Eigen::Map<const Eigen::VectorXd>(&numbers[i], static_cast<Eigen::Index>(width)));
  return vectors;
}

Json list_of(const Vectors& vectors) {
  Json list = Json::array();
  for (const auto& vector : vectors)
    for (const double x : vector) list.push_back(x);
  return list;
}

Matrix3d matrix_of(const Eigen::VectorXd& numbers) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data());
}

/// Returns the nearest matrix with orthonormal rows.
RowMatrix orthonormal(const RowMatrix& given) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(given, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return svd.matrixU() * svd.matrixV().transpose();
}

/// Returns the quaternion of a rotation with w ≥ 0. Of 4w², 4x², 4y², 4z² the largest is at least
/// 1; its row of 4qqᵀ has the quaternion without cancellation.
Vector4d quaternion_of(const std::string& place, Matrix3d Q, bool normalize) {
  const double defect = (Q * Q.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(defect <= (normalize ? rounded : exact)))
    throw BadInput(place + ": max |QQᵀ - I| = " + shown(defect) + ": must be a rotation to " +
                   shown(normalize ? rounded : exact) +
                   (defect <= rounded ? "; \"normalize\": true makes it so" : ""));
  if (Q.determinant() < 0)
    throw BadInput(place +
                   ": the determinant is -1: must be a rotation, not a reflection; are two axes "
                   "exchanged?");
  if (normalize) Q = orthonormal(Q);
  const Vector3d d = Q.diagonal();
  const double x = Q(2, 1) - Q(1, 2), y = Q(0, 2) - Q(2, 0), z = Q(1, 0) - Q(0, 1);
  const double xy = Q(0, 1) + Q(1, 0), xz = Q(0, 2) + Q(2, 0), yz = Q(1, 2) + Q(2, 1);
  Eigen::Matrix4d products;
  products << 1 + d.sum(), x, y, z,       //
      x, 1 + 2 * d[0] - d.sum(), xy, xz,  //
      y, xy, 1 + 2 * d[1] - d.sum(), yz,  //
      z, xz, yz, 1 + 2 * d[2] - d.sum();
  Eigen::Index largest;
  products.diagonal().maxCoeff(&largest);
  const Vector4d q = products.row(largest).transpose().normalized();
  return q[0] < 0 ? Vector4d(-q) : q;
}

Matrix3d rotation_of(const Eigen::VectorXd& q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  Matrix3d Q;
  Q << w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z;
  return Q;
}

/// Returns Ixx, Iyy, Izz, Ixy, Ixz, Iyz of matrices.
Vectors tensors_of(const std::string& place, const Json& given) {
  Vectors tensors = vectors_of(place, given, 9, "matrices of 3 x 3 numbers");
  for (auto& tensor : tensors) {
    const Matrix3d I = matrix_of(tensor);
    const double defect = (I - I.transpose()).cwiseAbs().maxCoeff();
    if (!(defect <= symmetric * I.cwiseAbs().maxCoeff()))
      throw BadInput(place + ": max |I - Iᵀ| = " + shown(defect) + ": must be a symmetric matrix");
    const Matrix3d mean = I / 2 + I.transpose() / 2;
    tensor.resize(6);
    tensor << mean(0, 0), mean(1, 1), mean(2, 2), mean(0, 1), mean(0, 2), mean(1, 2);
  }
  return tensors;
}

Vectors attitudes_of(const std::string& path, const Json& body, const std::string& order,
                     bool normalize) {
  const std::string place = path + "attitude";
  if (body.contains("mrp")) {
    if (body.contains("attitude"))
      throw BadInput(path + "mrp: must be absent where attitude is given");
    Vectors attitudes = vectors_of(path + "mrp", body["mrp"], 3, "3 for each attitude");
    for (auto& one : attitudes) {
      const Vector3d sigma = one;
      const double square = sigma.squaredNorm();
      one = (Vector4d() << 1 - square, 2 * sigma).finished() / (1 + square);
    }
    return attitudes;
  }
  if (!body.contains("attitude")) return {Vector4d::UnitX()};
  if (is_matrix(body["attitude"])) {
    Vectors attitudes = vectors_of(place, body["attitude"], 9, "matrices of 3 x 3 numbers");
    for (auto& one : attitudes) one = quaternion_of(place, matrix_of(one), normalize);
    return attitudes;
  }
  Vectors attitudes = vectors_of(place, body["attitude"], 4, "a quaternion or a rotation matrix");
  for (auto& q : attitudes) {
    if (order == "xyzw") q = Vector4d(q[3], q[0], q[1], q[2]);
    if (!normalize) continue;
    const double norm = q.norm();
    if (!(norm > 0 && std::isfinite(norm)))
      throw BadInput(place + ": of norm " + shown(norm) + ": must have a finite norm above 0");
    q /= norm;
  }
  return attitudes;
}

std::string choice(const std::string& path, Json& body, const char* name,
                   const std::array<const char*, 2>& choices) {
  const std::string chosen = body.value(name, choices[0]);
  if (chosen != choices[0] && chosen != choices[1])
    throw BadInput(path + name + ": " + Json(chosen).dump() + ": must be one of " + choices[0] +
                   ", " + choices[1]);
  body.erase(name);
  return chosen;
}

}  // namespace

std::vector<double> numbers_of(const std::string& place, const Json& list) {
  std::vector<double> numbers;
  for (const Json& one : flat(place, list)) {
    if (!one.is_number()) throw BadInput(place + ": must have numbers only");
    numbers.push_back(one.get<double>());
  }
  return numbers;
}

std::optional<std::vector<RowMatrix>> stacked(const std::string& place, const Json& block,
                                              std::size_t members) {
  if (!block.is_structured()) return std::nullopt;
  const Json matrix = matrix_of(place, block);
  if (matrix.contains("imaginary") || !matrix.contains("values")) return std::nullopt;
  const auto values = numbers_of(place, matrix["values"]);
  const auto rows = matrix.value("rows", std::size_t{0}),
             cols = matrix.value("cols", std::size_t{0});
  if (rows * cols != values.size() || values.empty() || rows % members != 0) return std::nullopt;
  std::vector<RowMatrix> each;
  const auto n = static_cast<Eigen::Index>(rows / members), N = static_cast<Eigen::Index>(cols);
  for (std::size_t b = 0; b < members; ++b)
    each.emplace_back(Eigen::Map<const RowMatrix>(&values[b * (values.size() / members)], n, N));
  return each;
}

void write_out_body(const std::string& path, Json& body, bool normalize) {
  for (auto field = body.begin(); field != body.end();)
    field = field->is_null() ? body.erase(field) : std::next(field);
  const std::string order = choice(path, body, "order", {"wxyz", "xyzw"}),
                    frame = choice(path, body, "frame", {"body", "space"});
  const bool by_momentum = body.contains("angular_momentum");
  const char* moving = by_momentum ? "angular_momentum" : "angular_velocity";
  if (body.contains("inertia_tensor") && is_matrix(body["inertia_tensor"]))
    body["inertia_tensor"] = list_of(tensors_of(path + "inertia_tensor", body["inertia_tensor"]));
  const bool turned = frame == "space" && body.contains(moving);
  const bool as_given = order == "wxyz" && !normalize && !body.contains("mrp") &&
                        !(body.contains("attitude") && is_matrix(body["attitude"]));
  if (as_given && !turned && !by_momentum) return;
  const Vectors attitudes = attitudes_of(path, body, order, normalize);
  if (body.contains("attitude") || body.contains("mrp")) body["attitude"] = list_of(attitudes);
  body.erase("mrp");
  if (!turned && !by_momentum) return;
  if (by_momentum && body.contains("angular_velocity"))
    throw BadInput(path + "angular_momentum: must be absent where angular_velocity is given");
  Vectors vectors = vectors_of(path + moving, body[moving], 3, "3 for each body");
  Vectors inertia;
  if (by_momentum && body.contains("moments"))
    inertia = vectors_of(path + "moments", body["moments"], 3, "3 for each body");
  else if (by_momentum && body.contains("inertia_tensor"))
    inertia = vectors_of(path + "inertia_tensor", body["inertia_tensor"], 6, "6 for each body");
  else if (by_momentum)
    throw BadInput(path + "angular_momentum: needs moments or inertia_tensor");
  const auto members = std::max({attitudes.size(), vectors.size(), inertia.size()});
  for (const Vectors* one : std::array<const Vectors*, 3>{&attitudes, &vectors, &inertia})
    if (one->size() > 1 && one->size() != members)
      throw BadInput(path + moving + ": the lists of `body` have different numbers of members");
  vectors.resize(members, vectors.front());
  for (std::size_t b = 0; b < members; ++b) {
    Vector3d vector = vectors[b];
    if (turned) vector = rotation_of(attitudes[attitudes.size() == 1 ? 0 : b]).transpose() * vector;
    if (by_momentum) {
      const auto& I = inertia[inertia.size() == 1 ? 0 : b];
      Matrix3d tensor = I.head<3>().asDiagonal();
      if (I.size() == 6) {
        tensor(0, 1) = tensor(1, 0) = I[3];
        tensor(0, 2) = tensor(2, 0) = I[4];
        tensor(1, 2) = tensor(2, 1) = I[5];
      }
      vector = tensor.partialPivLu().solve(vector);
    }
    vectors[b] = vector;
  }
  body.erase("angular_momentum");
  body["angular_velocity"] = list_of(vectors);
}

void make_fit(const std::string& path, const std::string& system,
              const std::vector<double>& inertia, Blocks& blocks) {
  for (auto& [name, members] : blocks)
    for (RowMatrix& block : members) {
      const RowMatrix given = block;
      if ((name == "Q" || name == "Q_prev" || name == "q") && given.rows() <= given.cols()) {
        block = orthonormal(given);
        check(path + name, (block - given).cwiseAbs().maxCoeff());
      } else if (name == "M" && given.rows() == given.cols()) {
        block = (given - given.transpose()) / 2;
        const double size = given.cwiseAbs().maxCoeff();
        check(path + name, (block - given).cwiseAbs().maxCoeff() / (size > 0 ? size : 1));
      }
    }
  const std::string moving = system == "stiefel" ? "S" : system == "ellipsoid" ? "qdot" : "";
  const auto velocity = blocks.find(moving), frame = blocks.find(moving == "qdot" ? "q" : "Q");
  if (velocity == blocks.end() || frame == blocks.end()) return;
  for (std::size_t b = 0; b < velocity->second.size(); ++b) {
    RowMatrix& block = velocity->second[b];
    const RowMatrix& Q = frame->second[b];
    const auto N = block.cols();
    Eigen::RowVectorXd scale = Eigen::RowVectorXd::Ones(N);
    if (moving == "S") {
      const std::size_t cols = static_cast<std::size_t>(N),
                        own = inertia.size() == cols ? 0 : b * cols;
      if (Q.rows() != block.rows() || Q.cols() != N || inertia.size() < own + cols) return;
      scale = Eigen::Map<const Eigen::RowVectorXd>(&inertia[own], N);
    }
    const RowMatrix Qdot = block.array().rowwise() / scale.array();
    const RowMatrix product = Qdot * Q.transpose();
    const RowMatrix off = (product + product.transpose()) / 2 * Q;
    const double size = Qdot.cwiseAbs().maxCoeff();
    check(path + moving, off.cwiseAbs().maxCoeff() / (size > 0 ? size : 1));
    block = (Qdot - off).array().rowwise() * scale.array();
  }
}

}  // namespace stiefel::cli
