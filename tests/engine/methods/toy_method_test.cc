#include <gtest/gtest.h>

#include "engine/methods/support/method.h"
#include "engine/rigid_body/body/rigid_body.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

/// Adding a method takes this struct in a file and its name in methods.inc.
struct ExplicitEuler {
  static constexpr MethodTraits traits = {.name = "explicit_euler",
                                          .summary = "x + hX(x)",
                                          .source = "Euler 1768",
                                          .file = "",
                                          .orders = {1},
                                          .default_order = 1,
                                          .reversible = false};
  static constexpr bool applies_to(const SystemTraits&) { return true; }
  static constexpr Conservation conservation(const SystemTraits&, std::string_view) {
    return Conservation::drifts;
  }

  template <System S>
  class Map : public ExplicitMap<Map<S>, S> {
   public:
    Map(S system, typename S::Scalar h, const MethodOptions& options)
        : ExplicitMap<Map, S>(std::move(system), h, options) {}
    void displacement(const typename S::State& x, typename S::State& dx) {
      this->system_.field(x, dx);
      dx *= this->h_;
    }
  };
};

TEST(ToyMethod, IsAMethodOnEverySpace) {
  using Body3 = RigidBody<So3<double, true>>;
  using BodyN = RigidBody<SoN<double>>;
  static_assert(GeneralMethod<ExplicitEuler> && applies<ExplicitEuler, BodyN>);
  static_assert(stiefel::Map<ExplicitEuler::Map<Body3>>);
  const testing::RandomBody body(5, 1);
  ExplicitEuler::Map<BodyN> map(BodyN(body.lambda), 0.5, {1, Arithmetic::plain});
  Eigen::MatrixXd x(10, 5);
  x << body.Q, body.M;
  auto state = map.start(x);
  ASSERT_TRUE(map.step(state).reached());
  Eigen::MatrixXd Omega(5, 5);
  SoN<double>::inverse_inertia(body.lambda, body.M, Omega);
  EXPECT_LT((state.x.value.topRows(5) - body.Q - 0.5 * body.Q * Omega).norm(), 1e-15);
}

}  // namespace
}  // namespace stiefel
