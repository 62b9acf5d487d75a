#include "engine/scene/scene_draft.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/dense/decompositions.h"
#include "engine/dense/orthogonal.h"
#include "engine/dense/so_3.h"
#include "engine/scene/near_name.h"

namespace stiefel {
namespace {

/// The range of numbers whose squares neither overflow nor underflow.
struct Scales {
  double least, largest;

  bool contain(double x) const { return std::abs(x) >= least && std::abs(x) <= largest; }
  std::string rule() const {
    return "must be " + to_text(least) + " to " + to_text(largest) +
           ": choose other units of mass, length and time";
  }
};

Scales scales(const SceneDescription& scene) {
  if (scene.method && scene.method->scalar == "float") return {1e-18, 1e18};
  return {1e-153, 1e153};
}

/// A step that turns a frame by more radians leaves no digit of its attitude.
constexpr double largest_turn = 0x1p52;

std::string element(std::string_view field, std::size_t k) {
  return std::string(field) + "[" + std::to_string(k) + "]";
}

/// Writes a quantity: "max |M| = 1e+200".
std::string equation(std::string_view what, double x) {
  return std::string(what) + " = " + to_text(x);
}

}  // namespace

std::string shape_text(Eigen::Index rows, Eigen::Index cols) {
  return std::to_string(rows) + " x " + std::to_string(cols);
}

void SceneDraft::refuse(std::string_view field, std::string value, std::string rule) {
  violations_.push_back({std::string(field), std::move(value), std::move(rule)});
}

std::expected<Scene, Violations> SceneDraft::take() {
  if (!sound()) return std::unexpected(std::move(violations_));
  return std::move(scene_);
}

void SceneDraft::check_step() {
  const auto& h = given().step;
  if (!h)
    refuse("step", "absent", "must be given, finite and not 0");
  else if (!std::isfinite(*h) || *h == 0)
    refuse("step", to_text(*h), "must be finite and not 0");
  else if (!scales(given()).contain(*h))
    refuse("step", to_text(*h), "|step| " + scales(given()).rule());
}

bool SceneDraft::check_number(std::string_view field, std::string_view what, double x) {
  if (scales(given()).contain(x)) return true;
  refuse(field, equation(what, x), std::string(what) + " " + scales(given()).rule());
  return false;
}

bool SceneDraft::check_size(std::string_view field, std::string_view what, double size) {
  if (size <= scales(given()).largest) return true;
  refuse(field, equation(what, size), std::string(what) + " " + scales(given()).rule());
  return false;
}

bool SceneDraft::check_velocity(std::string_view field, std::string_view what, double size) {
  if (!check_size(field, what, size)) return false;
  const double turn = std::abs(step()) * size;
  if (turn <= largest_turn || !scales(given()).contain(step())) return true;
  refuse("step", to_text(step()) + ", |step| " + equation(what, turn),
         "|step| " + std::string(what) + " must be at most " + to_text(largest_turn) +
             ": the angle of a step has no more digits");
  return false;
}

bool SceneDraft::check_momentum(const std::string& field, const Eigen::MatrixXd& M) {
  if (!check_size(field, "max |M|", M.cwiseAbs().maxCoeff())) return false;
  if (!sound()) return false;  // Λ may be invalid
  const Eigen::VectorXd& lambda = scene_.inertia_;
  double largest = 0;
  for (Eigen::Index j = 0; j < M.cols(); ++j)
    for (Eigen::Index i = 0; i < j; ++i)
      largest = std::max(largest, std::abs(M(i, j)) / (lambda(i) + lambda(j)));
  return check_velocity(field, "max |Ω|", largest);
}

bool SceneDraft::all_finite(std::string_view field, std::span<const double> values) {
  for (std::size_t k = 0; k < values.size(); ++k)
    if (!std::isfinite(values[k])) {
      refuse(element(field, k), to_text(values[k]), "must be finite");
      return false;
    }
  return true;
}

void SceneDraft::refuse_if(bool present, const std::string& field) {
  if (present) refuse(field, "given", "must be absent in a scene of " + std::string(system_->name));
}

void SceneDraft::refuse_other_numbers() {
  refuse_if(given().epsilon.has_value(), "epsilon");
  refuse_if(given().parameter.has_value(), "parameter");
  refuse_if(!given().inertia_u.empty(), "inertia_u");
  refuse_if(!given().inertia_v.empty(), "inertia_v");
}

bool SceneDraft::set_inertia(std::size_t least, std::size_t most) {
  const auto& lambda = given().inertia;
  if (lambda.size() < least || lambda.size() > most) {
    refuse("inertia", lambda.empty() ? "absent" : std::to_string(lambda.size()) + " numbers",
           "must have " + std::to_string(least) + " to " + std::to_string(most) + " numbers");
    return false;
  }
  if (!all_finite("inertia", lambda)) return false;
  scene_.inertia_ =
      Eigen::Map<const Eigen::VectorXd>(lambda.data(), static_cast<Eigen::Index>(lambda.size()));
  return true;
}

void SceneDraft::check_inertia_sums() {
  const auto& lambda = given().inertia;  // the two smallest decide
  std::vector<std::size_t> order(lambda.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t k) { return lambda[k]; });
  const double sum = lambda[order[0]] + lambda[order[1]], largest = lambda[order.back()];
  if (!(sum > 0))
    refuse("inertia",
           element("λ", order[0]) + " + " + element("λ", order[1]) + " = " + to_text(sum),
           "λ_i + λ_j must be > 0 for i ≠ j");
  else if (!scales(given()).contain(sum) || !scales(given()).contain(largest))
    refuse("inertia", "λ_i + λ_j from " + to_text(sum) + ", λ_i up to " + to_text(largest),
           scales(given()).rule());
}

void SceneDraft::check_inertia_positive() {
  for (std::size_t k = 0; k < given().inertia.size(); ++k)
    if (!(given().inertia[k] > 0))
      return refuse(element("inertia", k), to_text(given().inertia[k]),
                    "every λ_i must be > 0 when n < N; at n = N the system rigid_body needs only "
                    "λ_i + λ_j > 0");
    else if (!scales(given()).contain(given().inertia[k]))
      return refuse(element("inertia", k), to_text(given().inertia[k]), scales(given()).rule());
}

void SceneDraft::check_block_names(bool complex) {
  for (const auto& [name, block] : given().initial) {
    if (std::ranges::count(system_->blocks, name, &BlockInfo::name) == 0)
      refuse("initial." + name, shape_text(block.values.rows(), block.values.cols()),
             "the blocks of " + std::string(system_->name) + " are " +
                 listed(system_->blocks, &BlockInfo::name) +
                 did_you_mean(name, system_->blocks, &BlockInfo::name));
    if (!complex && block.imaginary.size() > 0)
      refuse("initial." + name + ".imaginary", std::to_string(block.imaginary.size()) + " values",
             "must be absent: the blocks of " + std::string(system_->name) + " are real");
  }
}

const RowMatrix* SceneDraft::block(const std::string& name, Eigen::Index rows, Eigen::Index cols,
                                   bool required) {
  const auto found = given().initial.find(name);
  const std::string shape = shape_text(rows, cols);
  if (found == given().initial.end()) {
    if (required) refuse("initial." + name, "absent", "must be given, " + shape);
    return nullptr;
  }
  const auto check = [&](const RowMatrix& part, const std::string& path) {
    if (part.rows() != rows || part.cols() != cols) {
      refuse(path, shape_text(part.rows(), part.cols()), "must be " + shape);
      return false;
    }
    for (Eigen::Index i = 0; i < rows; ++i)
      for (Eigen::Index j = 0; j < cols; ++j)
        if (!std::isfinite(part(i, j))) {
          refuse(path + "[" + std::to_string(i) + "," + std::to_string(j) + "]",
                 to_text(part(i, j)), "must be finite");
          return false;
        }
    return check_size(path, "max |" + name + "|", part.cwiseAbs().maxCoeff());
  };
  const Block& block = found->second;
  if (!check(block.values, "initial." + name)) return nullptr;
  if (block.imaginary.size() > 0 && !check(block.imaginary, "initial." + name + ".imaginary"))
    return nullptr;
  return &block.values;
}

void SceneDraft::set_block(const std::string& name, Eigen::MatrixXd value) {
  scene_.blocks_[name] = std::move(value);
}

void SceneDraft::set_frame(const std::string& name, const RowMatrix& given_Q) {
  Eigen::MatrixXd Q = given_Q;
  const double defect = orthogonality_defect(Q);
  if (!(defect <= largest_repair_))
    return refuse("initial." + name, "max |QQᵀ - I| = " + to_text(defect),
                  "must have orthonormal rows to " + to_text(largest_repair_));
  Q = repaired(Q);
  if (Q.rows() == Q.cols()) {
    scene_.determinant_ = determinant(Q) < 0 ? -1 : 1;
    if (Q.cols() == 3) scene_.attitude_ = quaternion_of(scene_.determinant_ * Q);
  }
  set_block(name, std::move(Q));
}

void SceneDraft::set_skew(const std::string& name, const RowMatrix& M) {
  const double defect = (M + M.transpose()).cwiseAbs().maxCoeff();
  if (!(defect <= Scene::skew_tolerance * M.cwiseAbs().maxCoeff()))
    return refuse("initial." + name, "max |M + Mᵀ| = " + to_text(defect), "must be skew-symmetric");
  if (!check_momentum("initial." + name, M)) return;
  // If M is skew, the difference is M to the last bit, even where M is denormal.
  set_block(name, M - (M + M.transpose()) / 2);
}

void SceneDraft::set_body(const Body3& body) {
  scene_.axes_ = body.axes;
  scene_.inertia_ = body.lambda;
  scene_.attitude_ = body.attitude;
  scene_.blocks_["Q"] = rotation_matrix<double>(body.attitude);
  scene_.blocks_["M"] = hat(body.m);
}

}  // namespace stiefel
