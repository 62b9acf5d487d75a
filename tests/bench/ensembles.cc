// Compares the processor time of a step of several bodies that advance together, N = 3 and 4, to
// that of the same bodies one after another: on each instruction set of this machine, and in an
// ensemble's Simulation. h‖Ω‖ = 0.1. Arguments: repeats, seconds per measurement.
#include <stdexcept>

#include "engine/body/body_packs.h"
#include "engine/numbers/pack.h"
#include "stiefel/simulation.h"
#include "tests/bench/measure.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_scene.h"

namespace {

using namespace stiefel;

constexpr int members = 1024;

SceneDescription body(int N, unsigned seed, const MethodDescription& method) {
  auto scene = testing::description(testing::RandomBody(N, seed), 0.1, "");
  scene.system = "rigid_body";
  scene.method = method;
  return scene;
}

/// Returns the nanoseconds per step and member. `advance(steps)` advances all members by `steps`.
template <class Advance>
double step_nanoseconds(double duration, int count, Advance&& advance) {
  std::int64_t steps = 4;
  double time = bench::processor_seconds([&] { advance(steps); });
  while (time < duration / 4) time = bench::processor_seconds([&] { advance(steps *= 2); });
  std::vector<double> times;
  for (int i = 0; i < 3; ++i)
    times.push_back(1e9 * bench::processor_seconds([&] { advance(steps); }) /
                    static_cast<double>(steps * count));
  return bench::median(times);
}

void check(const RunStatus& run_status) {
  if (!run_status.reached()) throw std::runtime_error(to_sentence(run_status));
}

double one_by_one(std::span<const Scene> scenes, double duration) {
  std::vector<std::unique_ptr<Simulation>> all;
  for (const Scene& scene : scenes) all.push_back(make_simulation(scene));
  return step_nanoseconds(duration, static_cast<int>(scenes.size()), [&](std::int64_t steps) {
    for (const auto& one : all) check(one->advance(steps));
  });
}

double as_ensemble(const Scene& ensemble, double duration) {
  const auto all = make_simulation(ensemble);
  return step_nanoseconds(duration, static_cast<int>(ensemble.members().size()),
                          [&](std::int64_t steps) { check(all->advance(steps)); });
}

double packed(PackedBodies& bodies, std::span<const Scene> scenes, double duration) {
  std::vector<double> states;
  for (int k = 0; k < bodies.lanes(); ++k) {
    const auto one = make_simulation(scenes[static_cast<std::size_t>(k)]);
    std::vector<double> state(one->saved_size());
    one->save(state);
    states.insert(states.end(), state.begin(), state.end());
  }
  return step_nanoseconds(duration, bodies.lanes(), [&](std::int64_t steps) {
    if (bodies.advance(states, steps).steps < steps) throw std::runtime_error("a hard step");
  });
}

template <class Scalar>
void compare(const std::string& name, int N, const MethodDescription& method, int repeats,
             double duration) {
  constexpr bool in_float = std::is_same_v<Scalar, float>;
  const std::string what = name + ", " + method.arithmetic + (in_float ? ", float" : "") +
                           ", N = " + std::to_string(N) + ", ";
  const auto comparison = [&](const std::string& on, std::optional<double> bound) {
    return bench::Comparison{what + on, "ns a body", "one by one", bound};
  };
  const auto bound = [N](double ratio) {
    return N == 3 && !in_float ? std::optional(1 / ratio) : std::nullopt;
  };
  constexpr int most = vector_width<Scalar>(Isa::avx512);
  auto avx2 = comparison("packs of " + std::to_string(most / 2) + ", AVX2", bound(3.5)),
       avx512 = comparison("packs of " + std::to_string(most) + ", AVX-512", bound(6)),
       whole = comparison("an ensemble of " + std::to_string(members), {});
  for (int i = 0; i < repeats; ++i) {
    std::vector<SceneDescription> scenes;
    for (int b = 0; b < members; ++b)
      scenes.push_back(body(N, static_cast<unsigned>(i * members + b + 1), method));
    const Scene ensemble = Scene::resolve(testing::ensemble_of(scenes)).value();
    const auto some = ensemble.members().range(0, most);
    std::vector<PackedBody> packed_bodies;
    for (const Scene& scene : some) packed_bodies.push_back(packed_body(scene));
    const auto bodies = side_by_side<Scalar>(ensemble, packed_bodies, most);
    const double alone = one_by_one(some, duration);
    if (widest_isa() != Isa::baseline)
      avx2.add(packed(*pack_bodies_on<Isa::avx2>(bodies), some, duration), alone);
    if (widest_isa() == Isa::avx512)
      avx512.add(packed(*pack_bodies_on<Isa::avx512>(bodies), some, duration), alone);
    whole.add(as_ensemble(ensemble, duration), alone);
  }
  if (!avx2.ours.empty()) report(avx2);
  if (!avx512.ours.empty()) report(avx512);
  report(whole);
}

}  // namespace

int main(int, char** argv) {
  const int repeats = std::stoi(argv[1]);
  const double duration = std::stod(argv[2]);
  const auto all = [&]<class Scalar>(const std::string& arithmetic, const std::string& scalar) {
    const auto method = [&](const char* name, std::optional<int> order) {
      return MethodDescription{name, order, {}, arithmetic, {}, scalar};
    };
    for (const int N : {3, 4}) {
      if (N == 4 && scalar == "float") continue;
      compare<Scalar>("rk4", N, method("rk4", {}), repeats, duration);
      compare<Scalar>("variational", N, method("variational", 2), repeats, duration);
    }
    compare<Scalar>("preprocessed_variational, order 10", 3, method("preprocessed_variational", 10),
                    repeats, duration);
  };
  for (const char* arithmetic : {"plain", "compensated"}) {
    all.operator()<double>(arithmetic, "double");
    all.operator()<float>(arithmetic, "float");
  }
}
