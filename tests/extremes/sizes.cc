#include <gtest/gtest.h>

#include <cmath>

#include "stiefel/diagnosis.h"
#include "tests/extremes/bodies.h"
#include "tests/extremes/side_by_side.h"
#include "tests/extremes/twin/twin.h"

namespace stiefel::extremes {
namespace {

/// Compares a large scene with the twins of the small scenes that it consists of.
void measure_side_by_side(const std::string& name, const std::vector<SceneDescription>& small,
                          int copies, std::int64_t steps) {
  const SideBySide many(small, copies);
  for (const SceneDescription& way : every_way(many.large())) {
    const std::string& method = way.method->name;
    if (method == "adaptive") continue;  // its step size depends on the whole state
    if (!long_form() && (method != "variational" || way.method->arithmetic == "plain")) continue;
    std::vector<MotionState> states;
    double kappa = 1;
    for (SceneDescription d : small) {
      d.method = way.method;
      const Scene scene = Scene::resolve(d).value();
      const auto twin = make_twin(scene);
      if (!twin) return;
      twin->advance(steps);
      states.push_back(twin->state());
      kappa = std::max(kappa, condition(scene, steps));
    }
    const Trial done = run(way, steps);
    Record r = record_of("sizes", name, way, done);
    r.measure = "rounding";
    r.value =
        done.reached()
            ? error_of(read_motion(*done.scene, *done.simulation), many.assembled(states)).largest()
            : 1;
    // The products sum over all axes, and the scene itself is rounded: a factor √N.
    const double N = static_cast<double>(way.inertia.size());
    r.bound = done.scene ? rounding_bound(*done.scene, steps, kappa) * std::sqrt(N) : 0;
    r.why =
        "100 κ u √(N steps), plain √N steps; against the small motions it consists of, in "
        "quadruple precision";
    report(r);
    if (done.reached() && method != "rk4") {
      r.measure = "orthogonality";
      r.value = *done.simulation->orthogonality();
      r.bound = rounding_bound(*done.scene, steps, 1);
      r.why = rounding_reason(*done.scene, 1);
      report(r);
    }
  }
}

TEST(Sizes, SmallestFrames) {
  measure({"sizes", "V(1,2)", geodesic(1, Eigen::Vector2d(1, 3), 0.1), 200});
  measure({"sizes", "V(1,2), Λ over 1 : 1e6", geodesic(1, Eigen::Vector2d(1, 1e6), 1e-4), 200});
  for (const int n : {1, 2, 3, 5, 8}) {
    if (!long_form() && n > 2) continue;
    measure({"sizes", "V(n,n+1), n = " + std::to_string(n),
             geodesic(n, spread_inertia(n + 1, 4), 0.1), n < 5 ? 100 : 10});
  }
}

TEST(Sizes, SO2) { measure({"sizes", "SO(2)", tumbling(Eigen::Vector2d(1, 3), 0.1), 200}); }

TEST(Sizes, LongestVector) {
  // One vector of 10⁶ numbers with four values of λ. The motion stays in the span of eight vectors,
  // the parts of q and of q̇ in each eigenspace, so that it is a motion on V(1,8).
  Eigen::VectorXd eight(8);
  eight << 1, 1, 2, 2, 3, 3, 4, 4;
  const SceneDescription small = geodesic(1, eight, 0.1);
  const Eigen::Index copies = long_form() ? 125'000 : 1'000, N = 8 * copies;
  Eigen::MatrixXd E = Eigen::MatrixXd::Zero(8, N);  // orthonormal rows, each in one eigenspace
  for (Eigen::Index a = 0; a < 8; a += 2) {
    const Eigen::MatrixXd two = random_frame(2, 2 * copies, static_cast<unsigned>(a + 1));
    for (Eigen::Index j = 0; j < 2 * copies; ++j)
      E.block(a, (j / 2) * 8 + a + j % 2, 2, 1) = two.col(j);
  }
  SceneDescription large = small;
  large.inertia.clear();
  for (Eigen::Index k = 0; k < copies; ++k)
    large.inertia.insert(large.inertia.end(), eight.begin(), eight.end());
  for (const char* block : {"Q", "S"})
    large.initial[block] = RowMatrix(small.initial.at(block).values * E);
  constexpr std::int64_t steps = 20;
  for (const SceneDescription& way : every_way(large)) {
    if (way.method->name == "adaptive") continue;
    SceneDescription d = small;
    d.method = way.method;
    const Scene scene = Scene::resolve(d).value();
    const auto twin = make_twin(scene);
    twin->advance(steps);
    const Trial done = run(way, steps);
    Record r = record_of("sizes", "V(1," + std::to_string(N) + ")", way, done);
    r.measure = "rounding";
    r.value = 1;
    if (done.reached()) {
      const Matrix<long double> wide = E.cast<long double>();
      const MotionState exact{twin->state().attitude * wide, twin->state().momentum * wide};
      r.value = error_of(read_motion(*done.scene, *done.simulation), exact).largest();
    }
    r.bound = rounding_bound(*done.scene, steps, condition(scene, steps));
    r.why =
        "100 κ u √steps, plain steps; against V(1,8) in quadruple precision, of which it is a "
        "rotated copy";
    report(r);
  }
}

TEST(Sizes, V_64_128) {
  const Eigen::VectorXd lambda = Eigen::Vector4d(1, 1.5, 2.2, 3);
  measure_side_by_side(long_form() ? "V(64,128)" : "V(16,32)",
                       {geodesic(2, lambda, 0.1, 1), geodesic(2, lambda, 0.1, 7)},
                       long_form() ? 32 : 8, 20);
}

TEST(Sizes, SO512) {
  const Eigen::VectorXd lambda = Eigen::Vector4d(1, 1.5, 2.2, 3);
  measure_side_by_side(long_form() ? "SO(512)" : "SO(64)",
                       {tumbling(lambda, 0.1, 1), tumbling(lambda, 0.1, 5)}, long_form() ? 128 : 16,
                       long_form() ? 2 : 10);
}

}  // namespace
}  // namespace stiefel::extremes
