#include "engine/simulation/scene.h"

#include <Eigen/LU>
#include <cmath>
#include <sstream>

#include "engine/linalg/orthogonal.h"
#include "engine/linalg/so_3.h"
#include "engine/simulation/catalogue.h"

namespace stiefel {
namespace {

std::string text(double x) {
  std::ostringstream out;
  out.precision(17);
  out << x;
  return out.str();
}

std::string text(const std::vector<double>& v) {
  std::string out = "[";
  for (std::size_t k = 0; k < v.size() && k < 8; ++k) out += (k > 0 ? ", " : "") + text(v[k]);
  return out + (v.size() > 8 ? ", …]" : "]");
}

template <class Items, class Name>
std::string listed(const Items& items, Name name) {
  std::string out;
  for (const auto& item : items) out += (out.empty() ? "" : ", ") + std::string(name(item));
  return out;
}

std::string element(const std::string& field, std::size_t k) {
  return field + "[" + std::to_string(k) + "]";
}

}  // namespace

/// Checks a description field by field and fills in a Scene.
class SceneResolver {
 public:
  explicit SceneResolver(SceneDescription description) {
    scene_.description_ = std::move(description);
  }

  std::expected<Scene, Violations> resolve() {
    check_system();
    if (system_ != nullptr) {
      check_method();
      if (given().body)
        check_body();
      else
        check_blocks();
    }
    if (!std::isfinite(given().step) || given().step == 0)
      refuse("step", text(given().step), "must be finite and not 0");
    if (!violations_.empty()) return std::unexpected(std::move(violations_));
    return std::move(scene_);
  }

 private:
  SceneDescription& given() { return scene_.description_; }

  void refuse(std::string field, std::string value, std::string rule) {
    violations_.push_back({std::move(field), std::move(value), std::move(rule)});
  }

  bool all_finite(const std::string& field, const std::vector<double>& values) {
    for (std::size_t k = 0; k < values.size(); ++k)
      if (!std::isfinite(values[k])) {
        refuse(element(field, k), text(values[k]), "must be finite");
        return false;
      }
    return true;
  }

  void check_system() {
    system_ = catalogue().system(given().system);
    if (system_ == nullptr)
      refuse("system", '"' + given().system + '"',
             "must be one of " + listed(catalogue().systems, [](auto& s) { return s.name; }));
  }

  void check_method() {
    auto& method = given().method;
    if (system_->discrete) {
      if (method)
        refuse("method", '"' + method->name + '"',
               std::string(system_->name) + " is a discrete system and takes no method");
      return;
    }
    const auto names = listed(system_->methods, [](auto& m) { return m.method; });
    if (!method) return refuse("method", "absent", "a continuous system needs one of " + names);
    const MethodInfo* info = nullptr;
    for (const auto& m : system_->methods)
      if (m.method == method->name) info = catalogue().method(m.method);
    if (info == nullptr)
      return refuse("method.name", '"' + method->name + '"', "must be one of " + names);
    check_order(*info);
    if (method->substeps.value_or(1) < 1 || method->substeps.value_or(1) > 1'000'000)
      refuse("method.substeps", std::to_string(*method->substeps), "must be 1 to 1000000");
    method->substeps = method->substeps.value_or(1);
    if (method->arithmetic.empty()) method->arithmetic = "compensated";
    if (method->arithmetic == "plain")
      scene_.arithmetic_ = Arithmetic::plain;
    else if (method->arithmetic != "compensated")
      refuse("method.arithmetic", '"' + method->arithmetic + '"', "must be compensated or plain");
  }

  /// `order` is given only for families of several orders; so a resolved scene has it only there.
  void check_order(const MethodInfo& info) {
    auto& order = given().method->order;
    bool known = false;
    for (const int o : info.orders) known = known || order.value_or(info.default_order) == o;
    if (!known)
      refuse("method.order", std::to_string(*order),
             "for " + std::string(info.name) + " must be one of " +
                 listed(info.orders, [](int o) { return std::to_string(o); }));
    order = order.value_or(info.default_order);
  }

  void check_body() {
    auto& body = *given().body;
    if (!given().inertia.empty())
      refuse("inertia", text(given().inertia), "must be absent when `body` is given");
    if (!given().initial.empty())
      refuse("initial", std::to_string(given().initial.size()) + " blocks",
             "must be absent when `body` is given");
    check_moments(body);
    if (body.angular_velocity.size() != 3)
      refuse("body.angular_velocity", text(body.angular_velocity), "must have 3 numbers");
    else
      all_finite("body.angular_velocity", body.angular_velocity);
    if (body.attitude.empty()) body.attitude = {1, 0, 0, 0};
    if (body.attitude.size() != 4)
      refuse("body.attitude", text(body.attitude), "must have 4 numbers: w, x, y, z");
    else if (all_finite("body.attitude", body.attitude) &&
             !(std::abs(Eigen::Vector4d(body.attitude.data()).norm() - 1) <=
               Scene::frame_tolerance))
      refuse("body.attitude", text(body.attitude),
             "must have norm 1 to " + text(Scene::frame_tolerance));
    if (violations_.empty()) set_body(body);
  }

  void check_moments(const BodyDescription& body) {
    const bool tensor = !body.inertia_tensor.empty();
    if (tensor == !body.moments.empty())
      return refuse("body",
                    tensor ? "inertia_tensor and moments" : "neither inertia_tensor nor moments",
                    "needs exactly one of inertia_tensor and moments");
    const std::string field = tensor ? "body.inertia_tensor" : "body.moments";
    const auto& given = tensor ? body.inertia_tensor : body.moments;
    if (given.size() != (tensor ? 6u : 3u))
      return refuse(
          field, text(given),
          tensor ? "must have 6 numbers: Ixx, Iyy, Izz, Ixy, Ixz, Iyz" : "must have 3 numbers");
    if (!all_finite(field, given)) return;
    Eigen::Matrix3d I = Eigen::Vector3d(given.data()).asDiagonal();
    if (tensor) {
      I(0, 1) = I(1, 0) = given[3];
      I(0, 2) = I(2, 0) = given[4];
      I(1, 2) = I(2, 1) = given[5];
    }
    axes_ = principal_axes(I);
    if (!(axes_.moments.minCoeff() > 0))
      refuse(field, "smallest principal moment " + text(axes_.moments.minCoeff()),
             "every principal moment must be > 0");
  }

  void set_body(const BodyDescription& body) {
    const Eigen::Matrix3d& R = axes_.rotation;
    const Eigen::Vector3d omega = R.transpose() * Eigen::Vector3d(body.angular_velocity.data());
    Eigen::Matrix<double, 7, 1> q = Eigen::Matrix<double, 7, 1>::Zero();
    q.head<4>() = Eigen::Vector4d(body.attitude.data()).normalized();
    const Eigen::Vector4d r = quaternion_of(R);
    scene_.axes_ = axes_;
    scene_.inertia_ = inertia_of_moments(axes_.moments);
    scene_.attitude_ = So3<double, true>::quaternion_times(q, r(0), r.tail<3>());
    scene_.Q_ = rotation_matrix<double>(scene_.attitude_);
    scene_.M_ = hat(axes_.moments.cwiseProduct(omega));
  }

  void check_blocks() {
    const auto& lambda = given().inertia;
    const std::size_t N = lambda.size();
    if (N < 2 || N > Scene::max_dimension)
      return refuse("inertia", std::to_string(N) + " numbers",
                    "must have 2 to " + std::to_string(Scene::max_dimension) + " numbers");
    if (!all_finite("inertia", lambda)) return;
    check_sums(lambda);
    scene_.inertia_ = Eigen::Map<const Eigen::VectorXd>(lambda.data(), static_cast<int>(N));
    for (const auto& [name, block] : given().initial) {
      bool known = false;
      for (const auto& b : system_->blocks) known = known || b.name == name;
      if (!known)
        refuse("initial." + name,
               std::to_string(block.rows()) + " x " + std::to_string(block.cols()),
               "the blocks of " + std::string(system_->name) + " are " +
                   listed(system_->blocks, [](auto& b) { return b.name; }));
    }
    if (const RowMatrix* M = square_block("M", true)) set_momentum(*M);
    if (const RowMatrix* Q = square_block("Q", false)) set_frame(*Q);
  }

  /// λ_i + λ_j > 0 for i ≠ j: the two smallest decide.
  void check_sums(const std::vector<double>& lambda) {
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
                 text(lambda[least] + lambda[second]),
             "λ_i + λ_j must be > 0 for i ≠ j");
  }

  const RowMatrix* square_block(const std::string& name, bool required) {
    const auto found = given().initial.find(name);
    const auto N = std::to_string(scene_.inertia_.size());
    if (found == given().initial.end()) {
      if (required) refuse("initial." + name, "absent", "must be given, " + N + " x " + N);
      return nullptr;
    }
    const RowMatrix& block = found->second;
    if (block.rows() != scene_.inertia_.size() || block.cols() != scene_.inertia_.size()) {
      refuse("initial." + name, std::to_string(block.rows()) + " x " + std::to_string(block.cols()),
             "must be " + N + " x " + N + ", as `inertia` has " + N + " numbers");
      return nullptr;
    }
    for (Eigen::Index i = 0; i < block.rows(); ++i)
      for (Eigen::Index j = 0; j < block.cols(); ++j)
        if (!std::isfinite(block(i, j))) {
          refuse("initial." + name + "[" + std::to_string(i) + "," + std::to_string(j) + "]",
                 text(block(i, j)), "must be finite");
          return nullptr;
        }
    return &block;
  }

  void set_momentum(const RowMatrix& M) {
    const double defect = (M + M.transpose()).cwiseAbs().maxCoeff();
    if (!(defect <= Scene::skew_tolerance * M.cwiseAbs().maxCoeff()))
      return refuse("initial.M", "max |M + Mᵀ| = " + text(defect), "must be skew-symmetric");
    scene_.M_ = M / 2 - M.transpose() / 2;
  }

  void set_frame(const RowMatrix& given_Q) {
    Eigen::MatrixXd Q = given_Q;
    const double defect = orthogonality_defect(Q);
    if (!(defect <= Scene::frame_tolerance))
      return refuse("initial.Q", "max |QᵀQ - I| = " + text(defect),
                    "must be orthogonal to " + text(Scene::frame_tolerance));
    const double rounding = 4 * static_cast<double>(Q.cols()) * 0x1p-53;
    if (defect > rounding) Q = nearest_orthogonal<double>(Q);
    scene_.Q_ = Q;
    scene_.determinant_ = Q.determinant() < 0 ? -1 : 1;
    if (Q.cols() == 3) scene_.attitude_ = quaternion_of(scene_.determinant_ * Q);
  }

  Scene scene_;
  const SystemInfo* system_ = nullptr;
  PrincipalAxes axes_;
  Violations violations_;
};

std::expected<Scene, Violations> Scene::resolve(SceneDescription description) {
  return SceneResolver(std::move(description)).resolve();
}

}  // namespace stiefel
