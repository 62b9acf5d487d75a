#include "tests/support/surveys/error_survey.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>

#include "engine/accuracy/series_equations.h"
#include "engine/body/parametric_rigid_body.h"
#include "engine/body/psi.h"
#include "engine/body/symmetric_rigid_body.h"
#include "engine/bracket/double_bracket.h"
#include "engine/frame/stiefel.h"
#include "engine/frame/stiefel_costate.h"
#include "engine/motion/body_view.h"
#include "engine/motion/system_entry.h"
#include "stiefel/catalogue.h"
#include "stiefel/error_estimate.h"
#include "stiefel/simulation.h"
#include "tests/support/exact_motion.h"
#include "tests/support/integrate.h"
#include "tests/support/scenes/any_scene.h"

namespace stiefel::testing {
namespace {

using Wide = long double;
using Dense = Matrix<Wide>;

template <class System>
Dense moved(System system, const Scene& scene, const char* first, const char* second, double t,
            Wide tolerance) {
  const Eigen::MatrixXd &a = scene.block(first), &b = scene.block(second);
  Dense x(a.rows() + b.rows(), a.cols());
  x << a.cast<Wide>(), b.cast<Wide>();
  return t == 0 ? x : integrate(std::move(system), x, static_cast<Wide>(t), tolerance);
}

template <class System>
Dense velocity(System system, const Dense& x) {
  Dense rate = x;
  system.field(x, rate);
  return rate.topRows(x.rows() / 2);
}

MotionState double_bracket(const Scene& scene, double t, Wide tolerance) {
  const auto vector = [](const std::vector<double>& v) {
    return Vector<Wide>(Eigen::Map<const Eigen::VectorXd>(v.data(), std::ssize(v)).cast<Wide>());
  };
  const auto& given = scene.description();
  const Dense x = moved(DoubleBracket<Wide>(vector(given.inertia_u), vector(given.inertia_v)),
                        scene, "Q", "P", t, tolerance);
  return present<Wide>({.complex = true}, x, x.rows() / 2);
}

/// Returns the motion of a system that `truth` does not name, from the state at step 0 by
/// `adaptive`: it shares the vector field with the scene's steps, but nothing with the reference.
MotionState by_small_steps(const Scene& scene, std::int64_t steps, Wide tolerance) {
  SceneDescription d = scene.description();
  d.method = MethodDescription{"adaptive", {}, {}, "", static_cast<double>(100 * tolerance)};
  const auto now = make_simulation(Scene::resolve(d).value());
  EXPECT_TRUE(now->advance(steps).reached()) << d.system;
  return read_motion(scene, *now);
}

/// The true attitude and momentum, in the form in which a simulation reports them.
MotionState truth(const Scene& scene, std::int64_t steps, Wide tolerance) {
  const double t = scene.time(steps);
  const std::string& system = scene.system();
  if (system == "double_bracket") return double_bracket(scene, t, tolerance);
  const Vector<Wide> lambda = scene.inertia().cast<Wide>();
  const Wide epsilon = scene.epsilon();
  const auto halves = [](const Dense& x) {
    return MotionState{x.topRows(x.rows() / 2), x.bottomRows(x.rows() / 2)};
  };
  const auto geodesic = [&](auto flow, const Dense& x) {
    return MotionState{x.topRows(x.rows() / 2), velocity(flow, x) * lambda.asDiagonal()};
  };
  if (system == "rigid_body" || system_entry(system)->view) {
    const bool right = catalogue().system(system)->side == Side::right;
    const Eigen::MatrixXd Q = right ? scene.Q().transpose() : scene.Q();
    const Motion body = exact_motion(scene.inertia(), Q, body_momentum(scene), t, tolerance);
    const Dense attitude = body.Q.cast<Wide>(), momentum = body.M.cast<Wide>();
    if (right) return {attitude.transpose(), -momentum};
    return {attitude, momentum};
  }
  if (system == "symmetric_rigid_body") {
    MotionState of =
        halves(moved(SymmetricRigidBody<Wide>(lambda, epsilon), scene, "Q", "P", t, tolerance));
    of.momentum = Psi<Wide>(of.attitude, of.momentum, epsilon);
    return of;
  }
  if (system == "parametric_rigid_body") {
    const Wide mu = scene.parameter();
    MotionState of = halves(
        moved(ParametricRigidBody<Wide>(lambda, mu, epsilon), scene, "Q", "P", t, tolerance));
    of.momentum = parametric_momentum<Wide>(of.attitude, of.momentum) / epsilon;
    of.momentum.diagonal() -= mu * lambda.cwiseAbs2();
    return of;
  }
  if (system == "ellipsoid") {
    const StiefelCostate<Wide> costate(lambda, 1);
    if (scene.block("p").size() > 0)
      return geodesic(costate, moved(costate, scene, "q", "p", t, tolerance));
    Dense x(2, lambda.size());
    x << scene.block("q").cast<Wide>(), scene.block("qdot").cast<Wide>() * lambda.asDiagonal();
    return halves(t == 0 ? x
                         : integrate(Stiefel<Wide>(lambda, 1), x, static_cast<Wide>(t), tolerance));
  }
  if (!system.starts_with("stiefel")) return by_small_steps(scene, steps, tolerance);
  const Eigen::Index n = scene.Q().rows();
  if (system == "stiefel")
    return halves(moved(Stiefel<Wide>(lambda, n), scene, "Q", "S", t, tolerance));
  const StiefelCostate<Wide> costate(lambda, n);
  return geodesic(costate, moved(costate, scene, "Q", "P", t, tolerance));
}

/// Returns the estimate divided by the true error of `value`. Returns nothing if the true error is
/// below 1e-14, or below ten times the difference of the two solutions `exact` and `other`.
std::optional<double> ratio(std::optional<double> estimate, const Dense& value, const Dense& exact,
                            const Dense& other, Wide unit) {
  const Wide error = (value - exact).cwiseAbs().maxCoeff() / unit,
             own = (other - exact).cwiseAbs().maxCoeff() / unit;
  if (!estimate || !(error > 1e-14L) || !(error > 10 * own)) return std::nullopt;
  return *estimate / static_cast<double>(error);
}

SceneDescription random_description(unsigned seed, std::int64_t& steps) {
  std::mt19937_64 generator(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * std::generate_canonical<double, 53>(generator);
  };
  const auto any_of = [&](const auto& list) -> const auto& {
    return list[static_cast<std::size_t>(uniform(0, static_cast<double>(list.size())))];
  };
  std::vector<const SystemInfo*> systems;
  for (const auto& system : catalogue().systems)
    if (!system.discrete) systems.push_back(&system);
  const SystemInfo& system = *any_of(systems);
  const MethodOnSystem& on = any_of(system.methods);
  const bool only_3 = on.where == "N = 3";
  const int N = only_3 ? 3 : static_cast<int>(uniform(3, 7));
  const double step = (uniform(0, 1) < 0.2 ? -1 : 1) * 0.01 * std::pow(20, uniform(0, 1));
  SceneDescription d = any_scene(std::string(system.name), std::string(on.method), seed, step, N);
  const auto& orders = catalogue().method(on.method)->orders;
  if (!orders.empty()) d.method->order = any_of(orders);
  if (uniform(0, 1) < 0.5) d.method->arithmetic = "plain";
  if (on.in_float && N == 3 && uniform(0, 1) < 0.15) d.method->scalar = "float";
  const bool own_steps = catalogue().method(on.method)->default_tolerance > 0;
  if (own_steps) d.method->tolerance = std::pow(10, uniform(-12, -4));
  steps = static_cast<std::int64_t>(std::pow(10, uniform(0.5, 2.5)));
  if (own_steps) steps = std::max<std::int64_t>(1, steps / 10);  // its scene has longer steps
  if (system.name == "parametric_rigid_body") steps = std::min<std::int64_t>(steps, 50);
  return d;
}

}  // namespace

ErrorOutcome survey_error(unsigned seed) {
  std::int64_t steps = 0;
  const SceneDescription d = random_description(seed, steps);
  std::ostringstream what;
  what << "seed " << seed << ": " << d.system << " by " << d.method->name << " "
       << d.method->order.value_or(0) << " " << d.method->arithmetic << " " << d.method->scalar
       << ", N = " << d.inertia.size() << ", " << steps << " steps of " << *d.step;
  ErrorOutcome out;
  out.scene = what.str();
  const Scene scene = Scene::resolve(d).value();
  const auto now = make_simulation(scene);
  now->advance(steps);  // a run may stop early
  const ErrorEstimate estimate = estimate_error(scene, *now, 5e10, {});
  out.reference = estimate.reference;
  out.missing = estimate.missing;
  const MotionState state = read_motion(scene, *now), exact = truth(scene, now->step(), 1e-17L),
                    other = truth(scene, now->step(), 1e-15L);
  out.attitude = ratio(estimate.attitude, state.attitude, exact.attitude, other.attitude, 1);
  out.momentum = ratio(estimate.momentum, state.momentum, exact.momentum, other.momentum,
                       exact.momentum.cwiseAbs().maxCoeff());
  return out;
}

void expect_estimates(unsigned first, unsigned count) {
  int judged = 0, high = 0, missing = 0;
  for (unsigned seed = first; seed < first + count; ++seed) {
    const ErrorOutcome outcome = survey_error(seed);
    missing += !outcome.missing.empty();
    for (const auto& ratio : {outcome.attitude, outcome.momentum}) {
      if (!ratio) continue;
      ++judged;
      high += *ratio > 10;
      EXPECT_GE(*ratio, 0.5) << outcome.scene << ", against " << outcome.reference;
    }
  }
  EXPECT_GT(judged, static_cast<int>(count));  // two for each scene with errors above 1e-14
  EXPECT_LE(high, judged / 20);
  EXPECT_LE(missing, static_cast<int>(count / 20));
}

}  // namespace stiefel::testing
