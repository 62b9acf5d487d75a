#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "engine/accuracy/reference.h"
#include "engine/body/psi.h"
#include "engine/dense/so_3.h"
#include "stiefel/catalogue.h"
#include "tests/extremes/bodies.h"
#include "tests/extremes/extremes.h"
#include "tests/extremes/twin/twin.h"

namespace stiefel::extremes {
namespace {

const Eigen::Vector3d moments(1, 1.7, 2.4);

/// Returns a scene of a symmetric system. With ε = 1, M has a P only if ‖M‖_op < 2.
SceneDescription symmetric(const std::string& system, double norm_M,
                           std::optional<double> epsilon) {
  SceneDescription d = top(moments, Eigen::Vector3d(0.6, -0.64, 0.48) * norm_M, 0.02);
  d.system = system;
  d.epsilon = epsilon;
  return d;
}
const char* const systems[] = {"symmetric_rigid_body", "right_symmetric_rigid_body",
                               "reduced_rigid_body"};

/// Returns the condition of Ψ⁻¹ near ‖M‖_op = 2.
double condition_of_P(double norm_M) { return 2 / std::sqrt((2 - norm_M) * (2 + norm_M)); }

TEST(Momentum, TowardsTwo) {
  constexpr std::int64_t steps = 50;
  for (int k = 1; k <= 15; ++k) {
    if (!long_form() && k % 5 != 0) continue;
    const double norm_M = 2 - std::pow(10, -k);
    for (const char* system : systems)
      for (const SceneDescription& way : every_way(symmetric(system, norm_M, 1))) {
        Trial done = run(way, steps);
        Record r = record_of("momentum", "‖M‖_op = 2 - 1e-" + std::to_string(k), way, done);
        r.measure = "error";
        r.bound = 0;
        r.value = std::numeric_limits<double>::infinity();
        r.why = "must be REACHED: " + done.sentence();
        if (done.reached()) {
          const double time = done.scene->time(steps);
          const auto exact = make_reference(*done.scene, {std::abs(time), 1e11})->at(time, {});
          const double h_omega = done.scene->step() * norm_M, angle = 1 + h_omega * steps;
          const double truncation = way.method->name == "adaptive"
                                        ? done.scene->tolerance() * steps
                                        : std::pow(h_omega, r.order) * angle;
          r.value = error_of(read_motion(*done.scene, *done.simulation), exact->state).largest();
          r.bound =
              rounding_bound(*done.scene, steps, angle * condition_of_P(norm_M)) + 10 * truncation;
          r.why = "κ of Ψ⁻¹, 1/√(1 - ‖M‖²/4), and (h‖Ω‖)^order; against the exact motion";
        }
        report(r);
      }
  }
}

/// For ‖M‖_op ≥ 2, ε = 1 is refused with a hint at an ε that works; a scene without ε is accepted.
TEST(Momentum, TwoAndBeyond) {
  for (const double norm_M : {2.0, std::nextafter(2.0, 3.0), 2.5, 100.0, 1e6, 1e150})
    for (const char* system : systems) {
      std::ostringstream name;
      name << "‖M‖_op = " << norm_M << ", ε = 1";
      SceneDescription d = symmetric(system, norm_M, 1);
      d.step = 0.04 / norm_M;
      d.method = MethodDescription{"munthe_kaas4", {}, {}, ""};
      const Trial refused = run(d, 1);
      Record r = record_of("momentum", name.str(), d, refused);
      r.measure = "refused with a rule";
      r.value = refused.outcome() != "REFUSED" ||
                refused.sentence().find("must be < 2; without epsilon") == std::string::npos;
      r.why = "Ψ⁻¹ ends at ‖εM‖_op = 2; the rule names an ε";
      report(r);
      d.epsilon.reset();
      const Trial taken = run(d, 50);
      r = record_of("momentum", name.str() + " left out", d, taken);
      r.measure = "change of ‖M‖";
      r.value = 1;
      if (taken.reached()) {
        const double before = d.initial.at("M").values.norm();
        r.value = std::abs(taken.simulation->get("M").norm() / before - 1);
        r.bound = rounding_bound(*taken.scene, 50, 1);
      }
      r.why = "100 u √steps";
      report(r);
    }
}

struct Scale {
  const char* name;
  double lambda, M, step;
};

/// The motion in other units is the same: s·M with h/s, and s·Λ with s·M or with s·h.
TEST(Momentum, Scales) {
  const Eigen::Vector3d m(0.8, -0.5, 0.4);
  for (const Scale& s :
       {Scale{"M of 1e150", 1, 1e150, 1e-150}, Scale{"M of 1e-150", 1, 1e-150, 1e150},
        Scale{"Λ and M of 1e150", 1e150, 1e150, 1}, Scale{"Λ and M of 1e-150", 1e-150, 1e-150, 1},
        Scale{"Λ of 1e150", 1e150, 1, 1e150}, Scale{"Λ of 1e-150", 1e-150, 1, 1e-150}}) {
    if (!long_form() && s.lambda == 1e150) continue;
    measure({"momentum", s.name, top(s.lambda * moments, s.M * m, 0.1 * s.step), 100});
    if (!long_form()) continue;
    SceneDescription five = tumbling(spread_inertia(5, 4), 0.1 * s.step);
    for (double& l : five.inertia) l *= s.lambda;
    five.initial.at("M").values *= s.M;
    measure({"momentum", std::string(s.name) + ", N = 5", five, 50});
    SceneDescription frames = geodesic(2, spread_inertia(5, 4), 0.1 * s.step);
    for (double& l : frames.inertia) l *= s.lambda;
    frames.initial.at("S").values *= s.M;
    measure({"momentum", std::string(s.name) + ", V(2,5)", frames, 50});
  }
}

/// A momentum of denormal numbers moves nothing even in the longest step allowed, and keeps its
/// digits.
TEST(Momentum, Denormals) {
  for (const double size : {1e-310, 4.94065645841246544e-324})
    measure({"momentum", "M of " + std::to_string(std::log10(size)).substr(0, 7) + " decades",
             top(moments, Eigen::Vector3d(size, -3 * size, 5 * size), 0.1), 20});
  for (const double small : {1e-310, 4.94065645841246544e-324})
    measure({"momentum", "one denormal element",
             top(moments, Eigen::Vector3d(small, 1, 0.5 * small), 0.1), 100});
}

TEST(Momentum, UnitsOutOfReach) {
  const Eigen::Vector3d m(0.8, -0.5, 0.4);
  for (const Scale& s :
       {Scale{"step of 1e160", 1, 1e-160, 1e160}, Scale{"step of 1e-310", 1, 1, 1e-310},
        Scale{"Λ of 1e160", 1e160, 1, 1}, Scale{"Λ of 1e-310", 1e-310, 1e-310, 1},
        Scale{"M of 1e160", 1, 1e160, 1e-150}}) {
    SceneDescription d = top(s.lambda * moments, s.M * m, 0.1 * s.step);
    d.method = MethodDescription{"variational", {}, {}, ""};
    const Trial refused = run(d, 1);
    Record r = record_of("momentum", s.name, d, refused);
    r.measure = "refused with a rule";
    r.value = refused.outcome() != "REFUSED" ||
              refused.sentence().find("other units") == std::string::npos;
    r.why = "squares of such numbers are none";
    report(r);
  }
}

TEST(Momentum, RestAndAxes) {
  measure({"momentum", "rest", top(moments, {0, 0, 0}, 0.1), 100});
  SceneDescription frames = geodesic(2, spread_inertia(5, 4), 0.1);
  frames.initial.at("S").values.setZero();
  for (const SceneDescription& way : every_way(frames)) {
    const Trial done = run(way, 100);
    Record r = record_of("momentum", "rest, V(2,5)", way, done);
    r.measure = "distance from the start";
    r.value = done.reached() ? (done.simulation->get("Q") - done.scene->Q()).norm() : 1;
    r.bound = done.scene ? rounding_bound(*done.scene, 100, 1) : 0;
    r.why = rounding_reason(*done.scene, 1);
    report(r);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name = "axis " + std::to_string(axis + 1);
    Eigen::Vector3d m = Eigen::Vector3d::Unit(axis);
    measure({"momentum", name + " exactly", top(moments, m, 0.1), 500});
    m((axis + 1) % 3) = std::numeric_limits<double>::epsilon() / 2;
    measure({"momentum", name + ", one ulp off", top(moments, m, 0.1), 500});
  }
}

}  // namespace
}  // namespace stiefel::extremes
