#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "stiefel/catalogue.h"
#include "tests/extremes/bodies.h"
#include "tests/extremes/extremes.h"
#include "tests/extremes/twin/twin.h"

namespace stiefel::extremes {
namespace {

/// I = (2, 3, 6) and m = (δ, 1, −δ′), which moves away from the second axis. Δ₂ is a positive
/// multiple of δ′² − δ², so that δ′ = δ is on the separatrix to the last bit. The distance from the
/// axis grows like e^{t/6}, and ‖Ω‖ = 1/3.
const Eigen::Vector3d moments(2, 3, 6);
constexpr double growth = 1.0 / 6, step = 0.3;

struct Side {
  const char* name;
  double ratio;  ///< δ′/δ
};
constexpr Side on = {"on it", 1};
constexpr Side sides[] = {{"below", 0.875}, on, {"above", 1.125}};

SceneDescription near_separatrix(double delta, double ratio, double h) {
  return top(moments, {delta, 1, -ratio * delta}, h);
}

std::string name(double delta, const Side& side) {
  std::ostringstream text;
  text << "δ = " << delta << ", " << side.name;
  return text.str();
}

/// Runs from the unstable axis through the first flip to the other side, where m₂ = −tanh 2. Later
/// motion depends on rounding: the error of Δ₂, about u, decides when m leaves the axis again.
TEST(Separatrix, FirstFlip) {
  for (const double delta : {1e-1, 1e-2, 1e-4, 1e-8, 1e-16, 1e-40, 1e-80, 1e-160})
    for (const Side& side : sides) {
      if (!long_form() && !(delta == 1e-1 || (delta == 1e-16 && side.ratio == 1))) continue;
      const double flipped = (std::log(4 / delta) + 2) / growth;
      measure({"separatrix", name(delta, side) + ": first flip",
               near_separatrix(delta, side.ratio, step),
               static_cast<std::int64_t>(flipped / step)});
    }
}

/// Returns the number of sign changes of m₂ over `samples` samples, `every` steps apart.
template <class State, class Advance>
int flips(std::int64_t samples, std::int64_t every, State m_2, Advance advance) {
  int count = 0;
  double before = m_2();
  for (std::int64_t k = 0; k < samples; ++k) {
    if (!advance(every)) return -1;
    const double now = m_2();
    count += now * before < 0;
    before = now;
  }
  return count;
}

/// Returns how many samples, `spacing` apart, the exact motion in quadruple precision takes for 100
/// flips.
std::int64_t samples_of_100_flips(const SceneDescription& scene, double spacing) {
  SceneDescription exact = scene;
  exact.method = MethodDescription{"exact", {}, {}, ""};
  exact.step = spacing;
  const auto twin = make_twin(Scene::resolve(exact).value());
  const auto m_2 = [&] { return static_cast<double>(twin->state().momentum(0, 2)); };
  double before = m_2();
  std::int64_t k = 0;
  for (int count = 0; count < 100 && k < 100'000; ++k) {
    twin->advance(1);
    const double now = m_2();
    count += now * before < 0;
    before = now;
  }
  return k + 5;  // well past the last flip
}

Conservation of_energy(const std::string& method) {
  for (const auto& on_system : catalogue().system("rigid_body")->methods)
    if (on_system.method == method)
      for (const auto& p : on_system.preserves)
        if (p.invariant == "energy") return p.conservation;
  return Conservation::drifts;
}

/// The motion flips 100 times. A method that steps loses Δ₂/G² ≈ δ² in the first flip if it is
/// below the rounding of m, which then is as large as G; the computed motion is then that of
/// another body.
TEST(Separatrix, HundredFlips) {
  for (const double delta : {1e-1, 1e-2, 1e-4, 1e-40, 1e-160})
    for (const Side& side : {sides[0], sides[2]}) {
      if (!long_form() && delta != 1e-1) continue;
      const std::int64_t every = std::llround(2 * std::log(4 / delta) / growth / 10 / step);
      const SceneDescription scene = near_separatrix(delta, side.ratio, step);
      const std::int64_t samples = samples_of_100_flips(scene, step * static_cast<double>(every));
      for (const SceneDescription& way : every_way(scene)) {
        const std::string& method = way.method->name;
        const bool exact = method == "exact";
        const Conservation energy = of_energy(method);
        // Neither a bound nor a limit is known here.
        if (energy != Conservation::exact && delta < 1e-1 && delta > 1e-40) continue;
        Trial done = run(way, 0);
        Record r = record_of("separatrix", name(delta, side) + ": 100 flips", way, done);
        const auto m_2 = [&] { return done.simulation->get("M")(0, 2); };
        const int count = flips(samples, every, m_2, [&](std::int64_t steps) {
          return done.simulation->advance(steps).reached();
        });
        r.measure = "flips missed of 100";
        r.value = count < 0 ? 100 : std::abs(count - 100);
        r.bound = exact ? 0 : 1 + 100 * std::pow(step / 3, std::max(2, r.order));
        r.why = exact ? "the closed form is right at every time"
                      : "the period is off by (h‖Ω‖)^order, the count by one";
        if (energy == Conservation::drifts && r.order < 4)
          r.limit = "the energy drifts by (h‖Ω‖)^order ‖Ω‖t, farther than Δ₂";
        if (!exact && delta <= 1e-40)
          r.limit =
              "a state in double precision forgets Δ₂/G² ≈ δ² < u in its first flip and flips as "
              "if "
              "δ were about √u; `exact` counts right";
        report(r);
      }
    }
}

/// On the separatrix there is exactly one flip.
TEST(Separatrix, OneFlipOnItExactly) {
  for (const double delta : {1e-1, 1e-8, 1e-160})
    for (const SceneDescription& way : every_way(near_separatrix(delta, 1, step))) {
      const bool exact = way.method->name == "exact";
      if (!exact && (!long_form() || way.method->name != "variational")) continue;
      const std::int64_t every = std::llround(std::log(4 / delta) / growth / 5 / step);
      Trial done = run(way, 0);
      Record r = record_of("separatrix", name(delta, on) + ": a single flip", way, done);
      const auto m_2 = [&] { return done.simulation->get("M")(0, 2); };
      const int count = flips(500, every, m_2, [&](std::int64_t steps) {
        return done.simulation->advance(steps).reached();
      });
      r.measure = "flips beyond one";
      r.value = std::abs(count - 1);
      r.bound = 0;
      r.why = "Δ₂ = 0: the motion tends to the second axis";
      if (!exact)
        r.limit =
            "rounding leaves the separatrix in the first flip and flips again; `exact` does not";
      report(r);
    }
}

}  // namespace
}  // namespace stiefel::extremes
