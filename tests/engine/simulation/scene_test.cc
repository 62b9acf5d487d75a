#include "stiefel/scene.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine/dense/so_3.h"
#include "stiefel/simulation.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using testing::description;
using testing::RandomBody;

SceneDescription good() { return description(RandomBody(3, 1), 0.1, "variational"); }
SceneDescription good_body() {
  SceneDescription d;
  d.system = "rigid_body";
  d.method = MethodDescription{"variational", {}, {}, ""};
  d.body = BodyDescription{
      {17023.3, 124825.7, 129112.2, 397.1, -2171.4, 344.2}, {}, {}, {0.01, 0.02, 0.05}};
  d.step = 0.5;
  return d;
}

TEST(Scene, ViolationsNameTheFieldsOfTheDescription) {
  SceneDescription d = good();
  d.step = 0;
  d.method->order = 3;
  d.initial["Q"].values *= 2;
  const auto fields = [&] {
    std::vector<std::string> out;
    const auto scene = Scene::resolve(d);
    for (const auto& violation : scene.error()) out.push_back(violation.field);
    return out;
  };
  const std::vector<std::string> expected = {"method.order", "initial.Q", "step"};
  EXPECT_EQ(fields(), expected);
  d.members = 1;
  EXPECT_EQ(fields(), expected);
}

TEST(Scene, OfADiscreteSystemHasNothingOfAMethod) {
  const Scene scene = Scene::resolve(description(RandomBody(3, 1), 0.1, "")).value();
  EXPECT_EQ(scene.method(), "");
  EXPECT_EQ(scene.order(), 0);
  EXPECT_EQ(scene.substeps(), 1);
  EXPECT_EQ(scene.tolerance(), 0);
  EXPECT_EQ(scene.arithmetic(), Arithmetic::compensated);
  EXPECT_FALSE(scene.in_float());
}

TEST(Scene, BodyComesBackInItsCallersAxes) {
  const Scene scene = Scene::resolve(good_body()).value();
  const auto simulation = make_simulation(scene);
  const auto field = [&](const char* name) {
    std::vector<double> out(9);
    for (std::size_t k = 0; k < simulation->fields().size(); ++k)
      if (simulation->fields()[k].name == name) {
        simulation->write(k, out);
        out.resize(static_cast<std::size_t>(simulation->fields()[k].size()));
        return out;
      }
    ADD_FAILURE() << name;
    return out;
  };
  const auto& t = scene.description().body->inertia_tensor;
  Eigen::Matrix3d I;
  I << t[0], t[3], t[4], t[3], t[1], t[5], t[4], t[5], t[2];
  const Eigen::Vector3d omega(scene.description().body->angular_velocity.data());
  const Eigen::Matrix3d M = hat(Eigen::Vector3d(I * omega));
  const auto Q = field("Q"), m = field("M"), q = field("quaternion"), w = field("angular_velocity");
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      EXPECT_NEAR(Q[3 * i + j], i == j, 1e-15);
      EXPECT_NEAR(m[3 * i + j], M(i, j), 1e-11);
    }
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(w[k], omega(k), 1e-16);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(q[k], k == 0, 1e-15);
}

}  // namespace
}  // namespace stiefel
