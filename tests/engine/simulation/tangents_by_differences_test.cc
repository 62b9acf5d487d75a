// The state transition matrix with the derivatives by Λ and by the step, in coordinates, against
// differences of the states of simulations: of scenes that differ in one number.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "engine/dense/decompositions.h"
#include "engine/dense/so_3.h"
#include "engine/growth/coordinates.h"
#include "engine/structure/symplectic_defect.h"
#include "stiefel/catalogue.h"
#include "stiefel/linearization.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_matrices.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;
constexpr std::int64_t steps_of_differences = 5;

/// Returns the blocks of a state, stacked, in the caller's axes.
Dense stacked_state(const Simulation& motion) {
  const Dense first = motion.get(motion.fields()[0].name),
              second = motion.get(motion.fields()[1].name);
  Dense x(first.rows() + second.rows(), first.cols());
  x << first, second;
  return x;
}
std::optional<Dense> end_of(const SceneDescription& description) {
  const auto scene = Scene::resolve(description);
  if (!scene) return std::nullopt;
  const auto motion = make_simulation(*scene);
  if (!motion->advance(steps_of_differences).reached()) return std::nullopt;
  return stacked_state(*motion);
}

/// Makes S tangent as a scene does, S − YQ with KY + YK = R + Rᵀ, K = QΛ⁻¹Qᵀ, R = SΛ⁻¹Qᵀ: a scene
/// itself repairs rounding alone.
void make_tangent_to_frames(SceneDescription& description) {
  const Dense Q = description.initial["Q"].values, S = description.initial["S"].values;
  const Eigen::Map<const Eigen::VectorXd> lambda(description.inertia.data(), Q.cols());
  const Dense G = lambda.cwiseInverse().asDiagonal() * Q.transpose(), R = S * G;
  const auto [k, V] = symmetric_eigen(Q * G);
  Dense Y = V.transpose() * (R + R.transpose()) * V;
  for (Eigen::Index j = 0; j < Y.cols(); ++j)
    for (Eigen::Index i = 0; i < Y.rows(); ++i) Y(i, j) /= k(i) + k(j);
  description.initial["S"] = Block(RowMatrix(S - V * Y * V.transpose() * Q));
}

/// Returns column k of the matrix as blocks.
Dense column_of(const Dense& basis, const Dense& matrix, Eigen::Index k, const Dense& shape) {
  return (basis * matrix.col(k)).reshaped<Eigen::RowMajor>(shape.rows(), shape.cols());
}

/// States of rk4 leave the rotations and frames, by h⁵, and its tangents have no coordinates there.
double most_off(const Scene& scene) { return scene.method() == "rk4" ? 3e-6 : 1e-10; }

/// Compares the columns of the parameters, behind `first` others, with differences of end(k, t):
/// the last state with λ_k, or the step behind them, changed by t.
template <class End>
void expect_parameters(const Dense& basis, const Dense& matrix, Eigen::Index first, End&& end,
                       const Dense& x, double most, const std::string& what) {
  for (Eigen::Index k = first; k < matrix.cols(); ++k) {
    const Dense zero = Dense::Zero(1, 1), one = Dense::Constant(1, 1, 8);
    const auto expected =
        derivative<double>([&](const Dense& t) { return end(k - first, t(0, 0)); }, zero, one);
    ASSERT_TRUE(expected) << what << " parameter " << k - first;
    EXPECT_LT((column_of(basis, matrix, k, x) - *expected / 8).norm(),
              most * (1 + expected->norm()))
        << what << " parameter " << k - first;
  }
}

/// Of scenes that hold Λ and blocks.
void expect_by_parameters(const SceneDescription& description, const std::string& what) {
  const auto scene = Scene::resolve(description);
  ASSERT_TRUE(scene) << what;
  const auto motion = make_simulation(*scene);
  auto tangent = Linearization::make(*scene, {{}, false, true, true}, *motion);
  ASSERT_TRUE(tangent) << what;
  const Eigen::Index first = (*tangent)->start_basis(*motion).cols();
  ASSERT_TRUE((*tangent)->advance(*motion, steps_of_differences).reached()) << what;
  const SceneDescription& given = scene->description();
  const auto end = [&](Eigen::Index k, double change) {
    SceneDescription other = given;
    if (k + 1 == (*tangent)->count() - first) *other.step += change;
    for (double& l : other.inertia)
      if (k-- == 0) l += change;
    if (other.system == "stiefel") make_tangent_to_frames(other);
    return end_of(other);
  };
  expect_parameters((*tangent)->basis(*motion), (*tangent)->vectors(*motion), first, end,
                    stacked_state(*motion), most_off(*scene), what);
}

TEST(TangentsByDifferences, OfEverySystemAndMethodByLambdaAndTheStep) {
  for (const SystemInfo& system : catalogue().systems)
    for (const MethodOnSystem& on : system.methods) {
      const std::string name(system.name), method(on.method);
      if (!on.has_tangent) continue;
      for (const int N : {3, 4}) {
        if (!on.where.empty() && N != 3) continue;  // for N = 3 alone
        SceneDescription description = testing::any_scene(name, method, 3, 0.1, N);
        expect_by_parameters(description, name + " " + method + " " + std::to_string(N));
      }
    }
}

TEST(TangentsByDifferences, OfBodiesThatMoveInProductsOfMatrices) {
  struct Case {
    int N, order, substeps;
    double step, spread;
  };
  // A step by which the body turns by nearly a radian has the Schur form in place of sweeps.
  for (const auto& [N, order, substeps, step, spread] :
       {Case{11, 2, 2, 0.1, 4}, Case{16, 4, 1, 0.1, 4}, Case{11, 2, 1, 0.2, 1000},
        Case{11, 2, 1, 0.92, 4}}) {
    SceneDescription body =
        testing::description(testing::RandomBody(N, 5, spread), step, "variational");
    body.method->order = order;
    body.method->substeps = substeps;
    expect_by_parameters(body, "N = " + std::to_string(N) + ", step " + std::to_string(step));
  }
}

/// A body in three dimensions given by I, attitude q and ω.
struct GivenBody {
  Eigen::Matrix3d I;
  Eigen::Vector4d q;
  Eigen::Vector3d m;

  SceneDescription scene(const std::string& kind, const std::string& system,
                         const std::string& method) const {
    SceneDescription out;
    out.system = system;
    if (!method.empty()) out.method = MethodDescription{method, {}, {}, ""};
    out.step = 0.1;
    const Eigen::Vector3d omega = I.llt().solve(m);
    if (kind == "(Q, M)") {
      const Eigen::Vector3d moments = I.diagonal();
      for (int i = 0; i < 3; ++i) out.inertia.push_back(moments.sum() / 2 - moments(i));
      out.initial["Q"] = Block(RowMatrix(rotation_matrix<double>(q)));
      out.initial["M"] = Block(RowMatrix(hat(m)));
      return out;
    }
    out.body.emplace();
    out.body->angular_velocity = {omega(0), omega(1), omega(2)};
    if (kind == "moments")
      out.body->moments = {I(0, 0), I(1, 1), I(2, 2)};
    else
      out.body->inertia_tensor = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
    if (kind != "tensor") out.body->attitude = {q(0), q(1), q(2), q(3)};
    return out;
  }
  /// The body turned by a rotation vector u along its axes, with m + v.
  GivenBody moved(const Eigen::Vector3d& u, const Eigen::Vector3d& v) const {
    Eigen::Vector4d turn(1, 0, 0, 0);
    if (const double angle = u.norm(); angle > 0) {
      turn(0) = std::cos(angle / 2);
      turn.tail<3>() = std::sin(angle / 2) / angle * u;
    }
    return {I, So3<double, true>::quaternion_times(q, turn(0), turn.tail<3>()), m + v};
  }
};

/// (η, δm) of a change of the state, Q over M.
Eigen::Matrix<double, 6, 1> body_coordinates(const Dense& x, const Dense& dx) {
  const Eigen::Matrix3d eta = x.topRows(3).transpose() * dx.topRows(3);
  Eigen::Matrix<double, 6, 1> out;
  out << vee(((eta - eta.transpose()) / 2).eval()), vee(Eigen::Matrix3d(dx.bottomRows(3)));
  return out;
}

/// All columns in the coordinates of the caller's axes, for a body in a scene of each kind.
void expect_of_body(const std::string& kind, const std::string& system, const std::string& method) {
  const std::string what = kind + " " + system + " " + method;
  const bool turned = kind.starts_with("tensor");
  GivenBody body{Eigen::Vector3d(2, 2.5, 3).asDiagonal(), {1, 0, 0, 0}, {0.4, 1.1, -0.7}};
  if (turned) body.I << 2, 0.3, -0.2, 0.3, 2.5, 0.1, -0.2, 0.1, 3;
  if (kind != "tensor") body.q = Eigen::Vector4d(0.8, 0.2, -0.4, 0.4).normalized();
  const auto resolved = Scene::resolve(body.scene(kind, system, method));
  ASSERT_TRUE(resolved) << what << " " << resolved.error().front().rule;
  const Scene& scene = *resolved;
  const Eigen::Matrix3d R =
      scene.axes() ? scene.axes()->rotation : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  const auto motion = make_simulation(scene);
  auto tangent = Linearization::make(scene, {{}, false, true, true}, *motion);
  ASSERT_TRUE(tangent) << what << " " << tangent.error().front().rule;
  const Dense x = stacked_state(*motion), basis = (*tangent)->start_basis(*motion);
  ASSERT_EQ(basis.cols(), 6) << what;
  ASSERT_TRUE((*tangent)->advance(*motion, steps_of_differences).reached()) << what;
  const Dense Phi = (*tangent)->vectors(*motion), y = stacked_state(*motion);
  for (Eigen::Index k = 0; k < Phi.cols(); ++k) {
    const auto end = [&](const Dense& by) -> std::optional<Dense> {
      const double t = by(0, 0);
      Eigen::Vector3d u = Eigen::Vector3d::Zero(), v = u;
      GivenBody other = body;
      if (k < 6) (k < 3 ? u : v)(k % 3) = t;
      if (k >= 6 && k < 9) {
        Eigen::Vector3d moments = Eigen::Vector3d::Constant(t);
        moments(k - 6) = 0;
        other.I += R * moments.asDiagonal() * R.transpose();
      }
      // A scene of a body without an attitude starts at Q = I: its state cannot be turned.
      SceneDescription description =
          other.moved(u, v).scene(kind == "tensor" ? "tensor, attitude" : kind, system, method);
      if (k == 9) *description.step += t;
      return end_of(description);
    };
    const auto dx = derivative<double>(end, Dense::Zero(1, 1), Dense::Constant(1, 1, 8));
    ASSERT_TRUE(dx) << what << " column " << k;
    const auto expected = body_coordinates(y, *dx / 8);
    EXPECT_LT((Phi.col(k) - expected).norm(), most_off(scene) * (1 + expected.norm()))
        << what << " column " << k;
    if (k >= 6) continue;
    const Dense b = basis.col(k).reshaped<Eigen::RowMajor>(6, 3);
    EXPECT_LT((body_coordinates(x, b) - Eigen::Matrix<double, 6, 1>::Unit(k)).norm(), 1e-14)
        << what << " start_basis " << k;
    EXPECT_NEAR(b.topRows(3).norm(), k < 3 ? std::sqrt(2) : 0, 1e-14) << what;
  }
}

TEST(TangentsByDifferences, OfBodiesGivenInEveryWay) {
  for (const SystemInfo& system : catalogue().systems) {
    const Tangents* tangents = tangents_of(system.name);
    for (const MethodOnSystem& on : system.methods) {
      const std::string name(system.name), method(on.method);
      for (const char* kind : {"moments", "tensor", "tensor, attitude", "(Q, M)"}) {
        GivenBody body{Eigen::Vector3d(2, 2.5, 3).asDiagonal(), {1, 0, 0, 0}, {0.4, 1.1, -0.7}};
        const auto scene = Scene::resolve(body.scene(kind, name, method));
        if (!on.has_tangent || !scene || tangents->space(*scene).tangent) continue;
        expect_of_body(kind, name, method);
      }
    }
  }
}

TEST(TangentsByDifferences, AnEnsembleIsRefused) {
  GivenBody body{Eigen::Vector3d(2, 2.5, 3).asDiagonal(), {1, 0, 0, 0}, {0.4, 1.1, -0.7}};
  SceneDescription description = body.scene("tensor", "rigid_body", "exact");
  description.members = 2;
  description.body->angular_velocity.insert(description.body->angular_velocity.end(), {1, 2, 3});
  const Scene scene = Scene::resolve(description).value();
  const auto refused = Linearization::make(scene, {}, *make_simulation(scene));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().front().rule.find("members"), std::string::npos);
}

/// Whatever the closed form, the derivative by the step of state k is k times the velocity there.
TEST(TangentsByDifferences, AClosedFormMovesAlongItsVelocityWithTheStep) {
  for (const char* kind : {"moments", "tensor", "tensor, attitude", "(Q, M)"}) {
    GivenBody body{Eigen::Vector3d(2, 2.5, 3).asDiagonal(), {1, 0, 0, 0}, {0.04, 0.125, 0.09}};
    if (std::string(kind).starts_with("tensor"))
      body.I << 2, 0.3, -0.2, 0.3, 2.5, 0.1, -0.2, 0.1, 3;
    SceneDescription description = body.scene(kind, "rigid_body", "exact");
    description.step = 1;
    const Scene scene = Scene::resolve(description).value();
    const auto motion = make_simulation(scene);
    auto tangent = Linearization::make(scene, {{}, false, false, true}, *motion);
    ASSERT_TRUE(tangent && (*tangent)->advance(*motion, 100).reached());
    const Eigen::Vector3d m = vee(Eigen::Matrix3d(motion->get("M"))), omega = body.I.llt().solve(m);
    Eigen::Matrix<double, 6, 1> expected;
    expected << 100 * omega, 100 * m.cross(omega);
    EXPECT_LT(((*tangent)->vectors(*motion).col(6) - expected).norm(), 1e-12 * expected.norm())
        << kind;
  }
}

}  // namespace
}  // namespace stiefel
