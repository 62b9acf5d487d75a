#include <gtest/gtest.h>

#include "engine/body/rigid_body_maps.h"
#include "engine/frame/stiefel_maps.h"
#include "engine/methods/rk4.h"
#include "engine/structure/symplectic_defect.h"
#include "stiefel/linearization.h"
#include "tests/support/linalg/quadruple.h"
#include "tests/support/one_step.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_matrices.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using testing::one_step, testing::Quad;
using Dense = Eigen::MatrixXd;

/// The largest relative error that a tangent may have.
constexpr double most = 1e-12;
constexpr double h = 0.1;

Block block(const Dense& A) {
  Block out;
  out.values = RowMatrix(A);
  return out;
}

Scene scene_of(const std::string& system, const std::string& method, int order,
               const Eigen::VectorXd& lambda, const char* lower, const Dense& Q, const Dense& P) {
  SceneDescription description;
  description.system = system;
  description.method.emplace();
  description.method->name = method;
  if (order > 0) description.method->order = order;
  description.step = h;
  description.inertia.assign(lambda.begin(), lambda.end());
  description.initial["Q"] = block(Q);
  description.initial[lower] = block(P);
  auto scene = Scene::resolve(std::move(description));
  if (!scene) throw std::runtime_error(scene.error().front().rule);
  return *std::move(scene);
}

/// Compares the tangent of a step with the step in quadruple precision, differentiated by
/// differences whose error is 1e-29, in four random directions: a wrong linear map differs from
/// the right one in almost every direction.
template <class Map>
void expect_derivative(const Scene& scene, const char* lower, Map map, const std::string& what) {
  const auto motion = make_simulation(scene);
  const auto coordinates = Linearization::make(scene, {}, *motion);
  ASSERT_TRUE(coordinates) << what;
  const Dense basis = (*coordinates)->basis(*motion),
              directions = basis * testing::RandomMatrices<double>(5).matrix(basis.cols(), 4);
  auto tangent = Linearization::make(scene, {directions, true, false, false}, *motion);
  ASSERT_TRUE(tangent) << what;
  const Eigen::Index rows = (*tangent)->rows(), cols = (*tangent)->cols();
  Dense x(rows, cols);
  x << motion->get("Q"), motion->get(lower);
  ASSERT_TRUE((*tangent)->advance(*motion, 1).reached()) << what;
  const Dense moved = (*tangent)->vectors(*motion);
  const auto phi = one_step(map);
  double worst = 0;
  for (Eigen::Index k = 0; k < directions.cols(); ++k) {
    const Dense u = directions.col(k).reshaped<Eigen::RowMajor>(rows, cols),
                v = moved.col(k).reshaped<Eigen::RowMajor>(rows, cols);
    const auto exact =
        derivative<Quad>(phi, Matrix<Quad>(x.cast<Quad>()), Matrix<Quad>(u.cast<Quad>()));
    ASSERT_TRUE(exact) << what;
    worst = std::max(worst, static_cast<double>((v.cast<Quad>() - *exact).norm() / exact->norm()));
  }
  EXPECT_LT(worst, most) << what;
}

template <class Method>
void expect_of_bodies(int N, unsigned seed, int order) {
  using System = RigidBody<SoN<Quad>>;
  const testing::RandomBody body(N, seed);
  const char* name = Method::traits.name;
  const Scene scene = scene_of("rigid_body", name, order, body.lambda, "M", body.Q,
                               body.M / std::max(1.0, body.M.norm()));
  expect_derivative(
      scene, "M",
      map_of(Method(), System(scene.inertia().cast<Quad>()), Quad(h),
             {std::max(order, Method::traits.default_order), Arithmetic::plain}),
      std::string(name) + " N = " + std::to_string(N) + ", seed " + std::to_string(seed));
}

TEST(TangentInQuadruplePrecision, OfBodies) {
  for (int N = 2; N <= 7; ++N)
    for (unsigned seed = 1; seed <= 20; seed += N > 5 ? 7 : 1) {
      expect_of_bodies<Variational>(N, seed, 2);
      if (N > 3) expect_of_bodies<Rk4>(N, seed, 0);  // N = 3 has it on the quaternion
    }
  for (const int order : {4, 6, 8})
    for (const int N : {3, 4, 5}) expect_of_bodies<Variational>(N, 3, order);
}

void expect_of_frames(int n, int N, unsigned seed, int order = 2) {
  using System = Stiefel<Quad>;
  const testing::RandomFrame<double> frame(n, N, seed, 4);
  const Scene scene = scene_of("stiefel", "variational", order, frame.lambda, "S", frame.Q,
                               frame.S / std::max(1.0, frame.S.norm()));
  expect_derivative(
      scene, "S",
      map_of(Variational(), System(scene.inertia().cast<Quad>(), n), Quad(h),
             {order, Arithmetic::plain}),
      "n, N = " + std::to_string(n) + ", " + std::to_string(N) + ", seed " + std::to_string(seed));
}

TEST(TangentInQuadruplePrecision, OfFrames) {
  for (int N = 2; N <= 7; ++N)
    for (int n = 1; n <= N; ++n)
      for (unsigned seed = 1; seed <= 20; seed += N > 5 ? 14 : N > 4 ? 7 : 1)
        expect_of_frames(n, N, seed);
  for (const int order : {4, 6, 8}) {
    expect_of_frames(2, 5, 3, order);
    expect_of_frames(3, 6, 3, order);
  }
}

}  // namespace
}  // namespace stiefel
