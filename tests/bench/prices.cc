// Predicts the prices of steps and makes the steps, so that callgrind can count their work. Each
// line of the input is a scene or, for members > 0, an ensemble:
//
//     system method|- order arithmetic scalar n N substeps seed h‖Ω‖ first steps members
//
// After `first` steps, `steps` steps are counted. The answer is the line, the price of these steps
// and the steps that the map took, or `refused`. `--list` prints each system with each of its
// methods: system, method, kind (discrete, explicit, implicit, closed_form, own_steps), orders,
// in_float, whether bodies advance together in vector registers, N ("-": any). `--caps` makes calls
// whose price is a cap, `--connect` only those that are searches of Connect. tests/bench/prices.py
// writes the lines.
#include <Eigen/LU>
#include <functional>
#include <iostream>
#include <sstream>
#include <vector>

#include "engine/motion/method_entry.h"
#include "engine/motion/system_entry.h"
#include "stiefel/connect.h"
#include "stiefel/price.h"
#include "stiefel/simulation.h"
#include "stiefel/tradeoff.h"
#include "tests/bench/sized_scene.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_scene.h"

using namespace stiefel;

/// One of the functions that callgrind counts. It writes a dump after each call.
extern "C" [[gnu::noipa]] void measured_steps(Simulation& simulation, std::int64_t steps) {
  simulation.advance(steps);
}
extern "C" [[gnu::noipa]] void measured_call(const std::function<void()>& call) { call(); }

namespace {

std::string answer(const std::string& line) {
  std::istringstream in(line);
  std::string system, method, arithmetic, scalar;
  int order = 0, substeps = 1;
  bench::Size size{};
  unsigned seed = 0;
  double step = 0;
  std::int64_t first = 0, steps = 0;
  unsigned members = 0;
  in >> system >> method >> order >> arithmetic >> scalar >> size.n >> size.N >> substeps >> seed >>
      step >> first >> steps >> members;
  if (method == "-") method.clear();
  const auto description = [&](unsigned from) {
    SceneDescription d = bench::sized_scene(system, method, size, from, step);
    if (method.empty()) return d;
    d.method = MethodDescription{
        method, order > 0 ? std::optional(order) : std::nullopt, substeps, arithmetic, {}, scalar};
    if (const double tolerance = catalogue().method(method)->default_tolerance; tolerance > 0) {
      d.method->tolerance = tolerance;
      d.method->substeps.reset();
    }
    return d;
  };
  std::vector<SceneDescription> bodies;
  for (unsigned b = 0; b < members; ++b) bodies.push_back(description(seed + b));
  const auto scene = Scene::resolve(members > 0 ? testing::ensemble_of(bodies) : description(seed));
  if (!scene) return "refused";
  const auto simulation = make_simulation(*scene);
  if (!simulation->advance(first).reached()) return "refused";
  const std::int64_t before = simulation->map_steps();
  measured_steps(*simulation, steps);
  if (simulation->step() != first + steps) return "stopped";  // counted, but not compared
  const double h_Omega = std::abs(scene->step()) / scene->substeps() * simulation->rate();
  const double counted = simulation->direct() ? 1 : static_cast<double>(steps) * scene->substeps();
  std::ostringstream out;
  const auto [n, N] = frame_size(*scene);
  const double one = step_price(*scene, h_Omega);
  const double all = members > 0 ? ensemble_step_price(*scene, members, one) : one;
  out << n << ' ' << N << ' ' << all * counted << ' ' << simulation->map_steps() - before << ' '
      << h_Omega << ' ' << (is_weighed(*scene) ? "counted" : "estimated");
  return out.str();
}

void list() {
  for (const auto& system : catalogue().systems) {
    const bool packed = system_entry(system.name)->packs;
    if (system.discrete)
      std::cout << system.name << " - discrete 0 no " << (packed ? "packed" : "no") << " -\n";
    for (const auto& on : system.methods) {
      if (on.method.empty()) continue;
      const MethodInfo& method = *catalogue().method(on.method);
      const MethodTraits& traits = method_entry(on.method)->traits;
      std::cout << system.name << ' ' << method.name << ' '
                << (method.default_tolerance > 0 ? "own_steps"
                    : method.orders.empty()      ? "closed_form"
                    : traits.iterates            ? "implicit"
                                                 : "explicit")
                << ' ';
      if (method.orders.empty()) std::cout << 0;
      for (std::size_t i = 0; i < method.orders.size(); ++i)
        std::cout << (i > 0 ? "," : "") << method.orders[i];
      const bool in_packs = packed && traits.packing != Packing::none;
      std::cout << ' ' << (on.in_float ? "float" : "no") << ' ' << (in_packs ? "packed" : "no")
                << ' ' << (on.where.empty() ? "-" : on.where) << '\n';
    }
  }
}

void say(const std::string& call, double cap) { std::cout << call << ' ' << cap << std::endl; }

/// Makes searches that their cap ends, in every part of a search, and some that finish earlier.
void connect_caps() {
  for (const auto& [n, N] :
       {std::pair{1, 2}, {1, 4}, {2, 4}, {3, 3}, {2, 6}, {4, 4}, {5, 8}, {8, 8}})
    for (const int restarts : {4, 60})
      for (const double cap : {1e7, 3e7}) {
        const testing::RandomFrame<double> from(n, N, 1, 4), to(n, N, 2, 4);
        TwoPointProblem problem;
        problem.inertia = from.lambda;
        problem.Q_0 = from.Q;
        problem.Q_T = to.Q;
        if (n == N && from.Q.determinant() * to.Q.determinant() < 0) problem.Q_T.row(0) *= -1;
        problem.restarts = restarts;
        problem.most_work = cap;
        measured_call([&] { (void)connect(problem); });
        say("connect_" + std::to_string(n) + "x" + std::to_string(N), cap);
      }
}

void caps() {
  for (const int N : {3, 5, 12}) {
    SceneDescription d = testing::any_scene("rigid_body", "", 7, 0.1, N);
    d.method.reset();
    d.tolerance = 1e-8;
    d.horizon = 1000;
    measured_call([&] { (void)choose_method(d); });
    say("choice", Choice::most_work);
    d.tolerance.reset();
    d.horizon = 20;
    TradeoffRequest request{d};
    request.budget = 1e9;
    request.repeats = 1;
    measured_call([&] {
      auto tradeoff = Tradeoff::prepare(request);
      if (tradeoff && (*tradeoff)->solve_reference({}))
        while ((*tradeoff)->next({})) {
        }
    });
    say("tradeoff", request.budget);
  }
  connect_caps();
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  limit_threads(1);  // callgrind counts only the calling thread
  if (what == "--list") {
    list();
  } else if (what == "--caps") {
    caps();
  } else if (what == "--connect") {
    connect_caps();
  } else {
    for (std::string line; std::getline(std::cin, line);)
      std::cout << line << " : " << answer(line) << std::endl;
  }
}
