#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "stiefel/catalogue.h"
#include "stiefel/diagnosis.h"
#include "tests/extremes/extremes.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/every_pair.h"

namespace stiefel::extremes {
namespace {

constexpr double h_omegas[] = {0.5, 0.9, 0.99, 1, 1.2, 3, 1e3, 1e9};

std::string frame_field(const std::string& system) { return system == "ellipsoid" ? "q" : "Q"; }

std::optional<Eigen::MatrixXd> one_step(SceneDescription d, double h) {
  d.step = h;
  const Trial done = run(d, 1);
  if (!done.reached()) return std::nullopt;
  return done.simulation->get(frame_field(d.system));
}

/// Returns the largest jump of the frame after one step as h grows from 0 to its full size. Another
/// branch is at least 1 away; near the edge of the domain the frame moves like the square root of
/// the distance from the edge.
double largest_jump(const SceneDescription& d, double h) {
  constexpr int parts = 100;
  double largest = 0;
  std::optional<Eigen::MatrixXd> before;
  for (int k = 1; k <= parts; ++k) {
    const auto now = one_step(d, h * k / parts);
    if (!now) return 2;
    if (before) largest = std::max(largest, (*now - *before).norm());
    before = now;
  }
  return largest;
}

void measure_step(SceneDescription d, double h_omega, double h, std::int64_t steps) {
  d.step = h;
  const Trial done = run(d, steps);
  std::ostringstream name;
  name << "h‖Ω‖ = " << h_omega << (h < 0 ? ", back" : "")
       << (d.inertia.size() == 3 ? ", N = 3" : "");
  Record r = record_of("steps", name.str(), d, done);
  const auto say = [&](const auto&... what) { report(r.with(what...)); };
  if (done.run_status.outcome == Outcome::left_domain) {
    // Starts from the state at which the first run ended.
    SceneDescription there = d;
    for (auto& [block, values] : there.initial)
      values = Block(RowMatrix(done.simulation->get(block)));
    if (done.simulation->step() > 0 && d.system.starts_with("symmetric")) return;  // P drifts off
    const double largest = std::copysign(*done.run_status.largest_step, h);
    const bool below = one_step(there, 0.998 * largest).has_value();
    const bool above = one_step(there, 1.004 * largest).has_value();
    const bool missed = !below || above;
    Record edge = r;
    if (missed && h_omega > 3 && d.method && d.method->name == "gauss4")
      edge.limit =
          "h‖Ω‖ of 1e9: gauss4's equations have no edge there, and how far they are solved is what "
          "the solver can";
    report(edge.with("edge", missed, 0, "0.998 of the largest step is solved, 1.004 of it is not"));
    const bool advised =
        to_sentence(done.run_status, *done.scene).find("method") != std::string::npos;
    if (!d.system.starts_with("symmetric_moser"))
      say("message", !advised, 0, "names a method that goes on");
    return;
  }
  if (!done.reached()) return say("outcome", 1, 0, "solved, or LEFT_DOMAIN");
  const Diagnosis diagnosis = diagnose(*done.scene, *done.simulation);
  if (diagnosis.orthogonality)
    say("orthogonality", *diagnosis.orthogonality, rounding_bound(*done.scene, steps, 1),
        rounding_reason(*done.scene, 1));
  if (!long_form() || steps != 1 || h < 0 || h_omega > 3) return;
  say("largest jump", largest_jump(d, h), 0.5,
      "the branch that starts at the identity: continuous in h, other branches are 1 away");
}

class Steps : public ::testing::TestWithParam<testing::Pair> {};
INSTANTIATE_TEST_SUITE_P(Catalogue, Steps, ::testing::ValuesIn(testing::every_pair()),
                         testing::name_of);

/// Every implicit method either solves its equation to rounding on the principal branch, or ends
/// with LEFT_DOMAIN and the largest step.
TEST_P(Steps, LargeOnes) {
  const auto& [system, method, N] = GetParam();
  // The blocks of these systems determine the step.
  if (system == "moser_veselov_pair" || system == "parametric_moser_veselov") return;
  const SceneDescription at_one = testing::any_scene(system, method, 3, 1, N);
  for (const SceneDescription& way : method.empty() ? std::vector{at_one} : every_way(at_one)) {
    if (way.method && way.method->name != method) continue;
    const Trial start = run(way, 0);
    ASSERT_TRUE(start.scene) << start.sentence();
    if (!start.simulation->largest_step(1)) continue;  // explicit
    const double rate = start.simulation->rate();
    for (const double h_omega : h_omegas)
      for (const double sign : {1.0, -1.0})
        for (const std::int64_t steps : {1, 20}) {
          if (!long_form() && (sign < 0) != (h_omega == 0.9)) continue;
          if (h_omega > 3 && steps > 1) continue;  // one step suffices
          // gauss4 takes 8 s of processor time for such a step of a body with N > 3.
          if (!long_form() && h_omega > 1e3 && method == "gauss4" && way.inertia.size() > 3)
            continue;
          measure_step(way, h_omega, sign * h_omega / rate, steps);
        }
  }
}

}  // namespace
}  // namespace stiefel::extremes
