#include "engine/simulation/scene/scene_draft.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "engine/linalg/lie/orthogonal.h"
#include "engine/linalg/lie/so_3.h"
#include "engine/simulation/accuracy/choice.h"
#include "engine/simulation/catalogue/recommendation.h"
#include "engine/simulation/catalogue/system_entry.h"
#include "engine/simulation/scene/near_name.h"

namespace stiefel {
namespace {

template <class Items, class Name>
std::string listed(const Items& items, Name name) {
  std::string out;
  for (const auto& item : items)
    out += (out.empty() ? "" : ", ") + std::string(std::invoke(name, item));
  return out;
}

/// Numbers whose squares are numbers.
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

std::string element(const std::string& field, std::size_t k) {
  return field + "[" + std::to_string(k) + "]";
}

}  // namespace

std::string shape_text(Eigen::Index rows, Eigen::Index cols) {
  return std::to_string(rows) + " x " + std::to_string(cols);
}

std::expected<Scene, Violations> SceneDraft::resolve() {
  const SystemEntry* entry = system_entry(given().system);
  if (entry == nullptr) {
    refuse("system", '"' + given().system + '"',
           "must be one of " + listed(catalogue().systems, &SystemInfo::name) +
               did_you_mean(given().system, catalogue().systems, &SystemInfo::name));
  } else {
    system_ = &entry->info;
    check_method();
    entry->check(*this);
    check_reach();
  }
  check_step();
  if (sound() && wants_choice()) choose();
  if (sound() && !given().method && !system_->discrete) recommend();
  if (!sound()) return std::unexpected(std::move(violations_));
  return std::move(scene_);
}

void SceneDraft::refuse(const std::string& field, std::string value, std::string rule) {
  violations_.push_back(place_.violation(field, std::move(value), std::move(rule)));
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

bool SceneDraft::all_finite(const std::string& field, const std::vector<double>& values) {
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

/// A tolerance takes the place of a method, and the two stand together only in what `choose` wrote.
void SceneDraft::check_choice() {
  const auto &tolerance = given().tolerance, &horizon = given().horizon;
  if (horizon && !(std::isfinite(*horizon) && *horizon > 0))
    refuse("horizon", to_text(*horizon), "must be finite and > 0");
  if (tolerance && !(*tolerance >= Scene::least_tolerance && *tolerance <= 1))
    refuse("tolerance", to_text(*tolerance),
           "must be " + to_text(Scene::least_tolerance) + " to 1");
  if (tolerance && !horizon)
    refuse("horizon", "absent", "must be given with `tolerance`: the time up to which it holds");
  if (tolerance && system_->discrete)
    refuse("tolerance", to_text(*tolerance),
           std::string(system_->name) + " is a discrete system: there is no method to choose");
  else if (tolerance && given().method && given().choice.empty())
    refuse("tolerance", to_text(*tolerance),
           "must be absent when `method` is given: it is for choosing one");
  if (!given().choice.empty() && !(given().method && tolerance))
    refuse("choice", '"' + given().choice + '"', "must be absent: the server writes it");
}

void SceneDraft::choose() {
  auto chosen = choose_method(given(), place_);
  if (chosen) {
    given().method = std::move(chosen->method);
    given().choice = std::move(chosen->reason);
  } else {
    for (Violation& violation : chosen.error()) violations_.push_back(std::move(violation));
  }
}

void SceneDraft::recommend() {
  const std::span<const Scene> alone(&scene_, 1);
  const Recommendation& one = recommendation_for(alone);
  given().method = one.description();
  check_method();
  given().method->substeps = one.substeps(alone);
}

void SceneDraft::check_method() {
  auto& method = given().method;
  check_choice();
  if (wants_choice()) return;
  if (system_->discrete) {
    if (method)
      refuse("method", '"' + method->name + '"',
             std::string(system_->name) + " is a discrete system and takes no method");
    return;
  }
  if (!method) return;  // the recommended one, once the state is known
  const auto names = listed(system_->methods, [](auto& m) { return m.method; });
  const MethodInfo* info = nullptr;
  for (const auto& m : system_->methods)
    if (m.method == method->name) info = catalogue().method(m.method);
  if (info == nullptr)
    return refuse("method.name", '"' + method->name + '"',
                  "must be one of " + names +
                      did_you_mean(method->name, system_->methods, &MethodOnSystem::method));
  check_order(*info);
  check_tolerance(*info);
  if (method->substeps.value_or(1) < 1 || method->substeps.value_or(1) > 1'000'000)
    refuse("method.substeps", std::to_string(*method->substeps), "must be 1 to 1000000");
  method->substeps = method->substeps.value_or(1);
  if (method->arithmetic.empty()) method->arithmetic = "compensated";
  if (method->arithmetic != "compensated" && method->arithmetic != "plain")
    refuse("method.arithmetic", '"' + method->arithmetic + '"', "must be compensated or plain");
  check_scalar();
}

void SceneDraft::check_scalar() {
  auto& method = *given().method;
  if (method.scalar.empty()) method.scalar = "double";
  if (method.scalar == "double") return;
  const auto rule = [&](const std::string& text) {
    refuse("method.scalar", '"' + method.scalar + '"', text);
  };
  if (method.scalar != "float") return rule("must be double or float");
  std::vector<MethodOnSystem> offered;
  std::ranges::copy_if(system_->methods, std::back_inserter(offered), &MethodOnSystem::in_float);
  if (offered.empty())
    rule("must be double: " + std::string(system_->name) + " is computed in nothing else");
  else if (std::ranges::find(offered, method.name, &MethodOnSystem::method) == offered.end())
    rule("of " + std::string(system_->name) + " is only for " +
         listed(offered, [](auto& m) { return m.method; }));
}

namespace {

/// The first method of a system that does.
std::string takes_every_inertia(const SystemInfo& system) {
  for (const auto& on : system.methods)
    if (!on.takes) return std::string(on.method);
  return "none";
}

}  // namespace

/// Once the system's own check has found out Λ.
void SceneDraft::check_reach() {
  const auto& lambda = scene_.inertia();
  for (const auto& on : system_->methods)
    if (given().method && on.method == given().method->name && lambda.size() > 0 && on.takes &&
        !on.takes(lambda))
      refuse("method.name",
             '"' + given().method->name + "\" with N = " + std::to_string(lambda.size()),
             "is only for " + std::string(on.where) + "; " + takes_every_inertia(*system_) +
                 " takes every Lambda");
}

/// An `order` must be one that the method has; a resolved scene has it unless the method has none.
void SceneDraft::check_order(const MethodInfo& info) {
  auto& order = given().method->order;
  if (info.orders.empty()) {
    if (order)
      refuse("method.order", std::to_string(*order),
             "must be absent: " + std::string(info.name) + " has no order");
    return;
  }
  bool known = false;
  for (const int o : info.orders) known = known || order.value_or(info.default_order) == o;
  if (!known)
    refuse("method.order", std::to_string(*order),
           "for " + std::string(info.name) + " must be one of " +
               listed(info.orders, [](int o) { return std::to_string(o); }));
  order = order.value_or(info.default_order);
}

void SceneDraft::check_tolerance(const MethodInfo& info) {
  auto& tolerance = given().method->tolerance;
  if (!info.default_tolerance) {
    if (tolerance)
      refuse("method.tolerance", to_text(*tolerance),
             std::string(info.name) + " takes steps of a fixed size and no tolerance");
    return;
  }
  if (!(tolerance.value_or(info.default_tolerance) >= 1e-15 && tolerance.value_or(1e-6) <= 1))
    refuse("method.tolerance", to_text(*tolerance), "must be 1e-15 to 1");
  tolerance = tolerance.value_or(info.default_tolerance);
}

bool SceneDraft::set_inertia(std::size_t least, std::size_t most) {
  const auto& lambda = given().inertia;
  if (lambda.size() < least || lambda.size() > most) {
    refuse("inertia", std::to_string(lambda.size()) + " numbers",
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
  std::size_t least = lambda[1] < lambda[0], second = 1 - least;
  for (std::size_t k = 2; k < lambda.size(); ++k) {
    if (lambda[k] < lambda[least]) {
      second = least;
      least = k;
    } else if (lambda[k] < lambda[second]) {
      second = k;
    }
  }
  if (!(lambda[least] + lambda[second] > 0))
    refuse("inertia",
           element("λ", least) + " + " + element("λ", second) + " = " +
               to_text(lambda[least] + lambda[second]),
           "λ_i + λ_j must be > 0 for i ≠ j");
  else if (!scales(given()).contain(lambda[least] + lambda[second]) ||
           !scales(given()).contain(*std::ranges::max_element(lambda)))
    refuse("inertia",
           "λ_i + λ_j from " + to_text(lambda[least] + lambda[second]) + ", λ_i up to " +
               to_text(*std::ranges::max_element(lambda)),
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
    bool known = false;
    for (const auto& b : system_->blocks) known = known || b.name == name;
    if (!known)
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
    return true;
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

bool SceneDraft::check_size(const std::string& name, const RowMatrix& block) {
  const double size = block.cwiseAbs().maxCoeff();
  if (size <= scales(given()).largest) return true;
  const std::string what = "max |" + name + "| ";
  refuse("initial." + name, what + "= " + to_text(size), what + scales(given()).rule());
  return false;
}

void SceneDraft::set_frame(const std::string& name, const RowMatrix& given_Q) {
  Eigen::MatrixXd Q = given_Q;
  const double defect = orthogonality_defect(Q);
  if (!(defect <= largest_repair_))
    return refuse("initial." + name, "max |QQᵀ - I| = " + to_text(defect),
                  "must have orthonormal rows to " + to_text(largest_repair_));
  const double rounding = 4 * static_cast<double>(Q.cols()) * 0x1p-53;
  if (defect > rounding) Q = nearest_orthogonal<double>(Q);
  if (Q.rows() == Q.cols()) {
    scene_.determinant_ = Q.determinant() < 0 ? -1 : 1;
    if (Q.cols() == 3) scene_.attitude_ = quaternion_of(scene_.determinant_ * Q);
  }
  set_block(name, std::move(Q));
}

void SceneDraft::set_skew(const std::string& name, const RowMatrix& M) {
  const double defect = (M + M.transpose()).cwiseAbs().maxCoeff();
  if (!(defect <= Scene::skew_tolerance * M.cwiseAbs().maxCoeff()))
    return refuse("initial." + name, "max |M + Mᵀ| = " + to_text(defect), "must be skew-symmetric");
  if (!check_size(name, M)) return;
  set_block(name, M - (M + M.transpose()) / 2);  // M itself, denormal or not, if that is skew
}

void SceneDraft::set_body(const PrincipalAxes& axes, const Eigen::Vector4d& attitude,
                          const Eigen::VectorXd& inertia, const Eigen::MatrixXd& M) {
  scene_.axes_ = axes;
  scene_.inertia_ = inertia;
  scene_.attitude_ = attitude;
  set_block("Q", rotation_matrix<double>(attitude));
  set_block("M", M);
}

}  // namespace stiefel
