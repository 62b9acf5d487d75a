// A scene with `body`: `exact` moves the body with exactly the given numbers, not the body with
// rounded λ, M and principal axes.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "engine/body/exact/euler_top.h"
#include "engine/scene/given_body.h"
#include "stiefel/conversion.h"
#include "stiefel/simulation.h"
#include "tests/support/linalg/quadruple.h"

namespace stiefel {
namespace {

using testing::Quad;
using Vec = Vector3<Quad>;
using Mat = Eigen::Matrix<Quad, 3, 3>;

BodyDescription of_moments(const Eigen::Vector3d& I, const Eigen::Vector3d& omega) {
  return {{}, {I(0), I(1), I(2)}, {0.5, -0.5, 0.5, 0.5}, {omega(0), omega(1), omega(2)}};
}

/// R diag(I) Rᵀ for a random R, rounded.
BodyDescription of_tensor(const Eigen::Vector3d& I, const Eigen::Vector3d& omega, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  Eigen::Vector4d q;
  for (double& c : q) c = normal(generator);
  q.normalize();
  const Eigen::Matrix3d R = rotation_matrix<double>(q);
  const Eigen::Matrix3d T = R * I.asDiagonal() * R.transpose();
  return {{T(0, 0), T(1, 1), T(2, 2), T(0, 1), T(0, 2), T(1, 2)},
          {},
          {0.5, 0.5, -0.5, 0.5},
          {omega(0), omega(1), omega(2)}};
}

Scene scene(const BodyDescription& body, double step) {
  SceneDescription d;
  d.system = "rigid_body";
  d.method = MethodDescription{"exact", {}, {}, "", {}};
  d.body = body;
  d.step = step;
  return Scene::resolve(d).value();
}

/// The body computed independently in quadruple precision: eigenvalues, axes, Iω and motion.
struct Oracle {
  Vec I;
  Mat R = Mat::Identity();  ///< its columns are the principal axes, in the caller's
  EulerTop<Quad>::Point start;

  explicit Oracle(const BodyDescription& body) {
    if (body.inertia_tensor.empty()) {
      I = Eigen::Vector3d(body.moments.data()).cast<Quad>();
    } else {
      const auto& T = body.inertia_tensor;
      Mat tensor;
      tensor << T[0], T[3], T[4], T[3], T[1], T[5], T[4], T[5], T[2];
      const Eigen::SelfAdjointEigenSolver<Mat> solver(tensor);
      I = solver.eigenvalues();
      R = solver.eigenvectors();
      if (R.determinant() < 0) R.col(0) = -R.col(0);
    }
    const Vec omega = R.transpose() * Eigen::Vector3d(body.angular_velocity.data()).cast<Quad>();
    const Eigen::Matrix<Quad, 4, 1> attitude =
        Eigen::Vector4d(body.attitude.data()).cast<Quad>().normalized();
    start << quaternion_of(Mat(rotation_matrix<Quad>(attitude) * R)), I.cwiseProduct(omega);
  }

  /// Attitude and angular velocity in the caller's axes.
  std::pair<Mat, Vec> at(const Quad& t) const {
    const EulerTop<Quad> top(PrincipalMoments3<Quad>(I, Vec(I(1) - I(2), I(2) - I(0), I(0) - I(1))),
                             start);
    const auto x = top.at(t);
    return {rotation_matrix<Quad>(x.head<4>()) * R.transpose(), R * x.tail<3>().cwiseQuotient(I)};
  }
};

/// Roundings of what is reported, and those of the closed form in extended precision, which act on
/// an angle ‖ω‖t: 2⁻⁶⁴ each. Λ and Iω in doubles would be 2⁻⁵³ ‖ω‖t.
double bound(double omega, double t) { return 16 * 0x1p-53 + 0x1p-60 * omega * t; }

void expect_follows(const BodyDescription& body, const std::string& name) {
  const Oracle oracle(body);
  const double omega = Eigen::Vector3d(body.angular_velocity.data()).norm();
  for (const double step : {1.0, -1e3, 1e6, 1e9}) {
    const auto simulation = make_simulation(scene(body, step));
    for (const std::int64_t k : {1, 7, 1000}) {
      ASSERT_TRUE(simulation->advance(k - simulation->step()).reached());
      const double t = static_cast<double>(k) * step;
      const auto [Q, w] = oracle.at(Quad(k) * Quad(step));
      const double off = static_cast<double>((simulation->get("Q").cast<Quad>() - Q).norm());
      EXPECT_LT(off, bound(omega, std::abs(t))) << name << " at " << t;
      const Eigen::Vector3d reported = simulation->get("angular_velocity").transpose();
      const double of_omega = static_cast<double>((reported.cast<Quad>() - w).norm());
      EXPECT_LT(of_omega, omega * bound(omega, std::abs(t))) << name << " at " << t;
    }
  }
}

TEST(GivenBody, ExactFollowsItsMoments) {
  expect_follows(of_moments({0.1, 0.25, 0.3}, {0.7, 1.1, -0.3}), "generic");
  expect_follows(of_moments({1, 1.0 / 3, 0.9}, {0.1, 1e-3, 2.3}), "near an axis");
  expect_follows(of_moments({0.3, 0.1, 0.2}, {0.3, 0.7, 0.1}), "unsorted");
  expect_follows(of_moments({0.1, 0.1, 0.17}, {0.7, 0.3, 1.1}), "symmetric");
  expect_follows(of_moments({0.1, 0.2, 0.1 + 0.2}, {0.7, 0.3, 1.1}), "flat");
  expect_follows(of_moments({0.1, 0.1, 0.1}, {0.7, 0.3, 1.1}), "sphere");
  expect_follows(of_moments({0.1, 0.3, 0.7}, {0.7, 0.3, 1.1}), "of no body");
  expect_follows(of_moments({0.1, 0.2, 0.15}, {0, 0, 0.9}), "steady");
}

TEST(GivenBody, ExactFollowsItsTensor) {
  for (unsigned seed = 1; seed <= 6; ++seed)
    expect_follows(of_tensor({1, 1.7, 2.3}, {0.7, 1.1, -0.3}, seed), "tensor");
  expect_follows(of_tensor({1, 1, 1.6}, {0.7, 1.1, -0.3}, 7), "nearly symmetric tensor");
  expect_follows(of_tensor({1, 1 + 1e-9, 1.6}, {0.7, 1.1, -0.3}, 8), "nearly symmetric tensor");
}

/// The motion before time 0 is that of the scene's numbers too, to 10⁵ years.
TEST(GivenBody, IsItsOwnSceneAtStep0) {
  for (const BodyDescription& body : {of_moments({1.7, 2.9, 3.1}, {0.3, -0.2, 0.7}),
                                      of_tensor({1, 1.7, 2.3}, {0.3, -0.2, 0.7}, 3)}) {
    const Scene given = scene(body, 3.15e9);
    SceneDescription back = scene_at(given, *make_simulation(given)).value().description();
    back.step = -*back.step;
    const auto simulation = make_simulation(Scene::resolve(back).value());
    ASSERT_TRUE(simulation->advance(1000).reached());
    const auto [Q, w] = Oracle(body).at(Quad(-3.15e12));
    const double off = static_cast<double>((simulation->get("Q").cast<Quad>() - Q).norm());
    EXPECT_LT(off, bound(0.8, 3.15e12));
  }
}

/// `momentum_tail` holds the rounding error of M.
TEST(GivenBody, MomentumTailCompletesM) {
  for (const BodyDescription& body : {of_moments({0.1, 0.25, 0.3}, {0.7, 1.1, -0.3}),
                                      of_tensor({1, 1.7, 2.3}, {0.7, 1.1, -0.3}, 3)}) {
    const Scene given = scene(body, 1);
    const auto extended = extended_body(given);
    ASSERT_TRUE(extended);
    // ω and I have a scale of 1 in the scene's axes too, whose columns are doubles.
    const Mat R = given.axes()->rotation.cast<Quad>();
    const Oracle oracle(body);
    const Vec in_caller_axes = oracle.R * oracle.start.tail<3>();
    const Vec whole = vee(given.M()).cast<Quad>() + extended->momentum_tail.cast<Quad>();
    EXPECT_GT(extended->momentum_tail.norm(), 0);
    EXPECT_LT(extended->momentum_tail.norm(), 0x1p-48);
    EXPECT_LT(static_cast<double>(abs(Quad(whole.norm() - in_caller_axes.norm()))), 0x1p-61);
    EXPECT_LT(static_cast<double>((R * whole - in_caller_axes).norm()), 0x1p-49);
  }
  SceneDescription d;
  d.system = "rigid_body";
  d.method = MethodDescription{"exact", {}, {}, "", {}};
  d.inertia = {1, 2, 3};
  d.initial["M"] = RowMatrix(RowMatrix::Zero(3, 3));
  d.step = 1;
  EXPECT_FALSE(extended_body(Scene::resolve(d).value()));
}

}  // namespace
}  // namespace stiefel
