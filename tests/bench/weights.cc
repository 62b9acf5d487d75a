// Makes steps of every method on one system in several sizes, so that callgrind can count them one
// by one. After each count it prints "system method|- order arithmetic scalar n N steps h‖Ω‖
// price", the price being what the engine takes a step for. A system whose bodies advance together
// in vector registers appears again as packed_SYSTEM, with the steps of a pack.
// tests/bench/weights.py reads both. Arguments: the system, and the only method to be counted;
// without them, prints the names of the systems.
#include <iostream>
#include <numeric>
#include <set>

#include "engine/motion/method_entry.h"
#include "engine/motion/packed_bodies.h"
#include "engine/motion/step_weight.h"
#include "engine/motion/system_entry.h"
#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"
#include "tests/bench/sized_scene.h"
#include "tests/support/scenes/ensemble_of.h"

using namespace stiefel;

/// The function that callgrind counts. It writes a dump after each call.
extern "C" [[gnu::noinline]] void measured_steps(Simulation& simulation, std::int64_t steps) {
  simulation.advance(steps);
}

namespace {

using bench::Size;

constexpr double h_Omega = 0.1;

/// Returns whether every step takes the same instructions: for explicit methods and closed forms.
/// The table then has all remainders of N by the lanes of a register. For methods that iterate the
/// count varies from step to step, and a few sizes suffice.
bool counts_repeat(const std::string& method) {
  const MethodEntry* entry = method_entry(method);
  return entry && !entry->traits.iterates && entry->traits.default_tolerance == 0;
}

std::vector<Size> frame_sizes(const std::string& method, int order) {
  if (!counts_repeat(method)) {
    std::vector<Size> few = {{1, 4},  {1, 32},  {2, 5},   {3, 3},   {3, 12}, {4, 4},
                             {4, 8},  {4, 32},  {6, 6},   {6, 12},  {8, 8},  {8, 16},
                             {8, 40}, {12, 12}, {12, 40}, {16, 16}, {16, 64}};
    if (order <= 2) few.insert(few.end(), {{2, 1000}, {4, 1000}, {8, 1000}, {32, 32}, {32, 64}});
    return few;
  }
  std::vector<Size> all;
  for (const int n : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 16, 17, 18, 19, 32, 33, 64}) {
    std::set<int> columns = {n, 32, 40, 64};
    if (n < 10) columns.insert({n + 1, n + 2, n + 3, 8, 9, 10, 11, 12, 16, 20});
    for (const int N : columns)
      if (N >= std::max(n, 3)) all.push_back({n, N});
  }
  return all;
}

/// Returns the N that are counted for systems with n = N and for the ellipsoid.
std::vector<int> dimensions(const std::string& method, int order) {
  if (!counts_repeat(method)) {
    std::vector<int> few = {3, 4, 5, 6, 8, 10, 12, 16, 24, 32};
    if (order <= 2) few.push_back(64);
    return few;
  }
  std::vector<int> all(17);
  std::iota(all.begin(), all.end(), 3);
  all.insert(all.end(), {32, 33, 34, 35, 64, 65, 66, 67});
  return all;
}

std::vector<Size> sizes(const std::string& system, const std::string& method, int order) {
  const SystemEntry& entry = *system_entry(system);
  if (entry.example) {
    const Scene one = resolve_recommending(testing::any_scene(system, "", 1, h_Omega)).value();
    const auto [n, N] = frame_size(one);
    return {{static_cast<int>(n), static_cast<int>(N)}};
  }
  if (system == "double_bracket") return {{2, 3}};
  if (system.starts_with("parametric")) return {{4, 4}};
  if (system == "discrete_stiefel") return {{2, 5}};
  if (bench::on_frames(system) && system != "ellipsoid") return frame_sizes(method, order);
  std::vector<Size> found;
  for (const int N : dimensions(method, order)) found.push_back({system == "ellipsoid" ? 1 : N, N});
  return found;
}

/// The h‖Ω‖ at which methods that iterate are counted in addition to h_Omega.
constexpr double other_rates[] = {0.01, 0.03, 0.3};

std::vector<Size> sizes_for_rates(const std::string& system, const std::string& method, int order) {
  const auto all = sizes(system, method, order);
  if (counts_repeat(method)) return {};
  if (all.size() == 1) return all;
  std::vector<Size> found;
  for (const Size size : all)
    if (size.N == 3 || size.N == 4 || size.N == 8 || (size.N == 16 && order <= 4))
      if (found.empty() || found.back().N < size.N) found.push_back(size);
  return found;
}

void count(SceneDescription description, Size size) {
  const auto scene = Scene::resolve(std::move(description));
  if (!scene) return;  // the method is for other sizes
  const auto simulation = make_simulation(*scene);
  // Steps after which a warm-started solver has a full history.
  const int first = counts_repeat(std::string(scene->method())) ? 1 : size.N <= 12 ? 16 : 6;
  constexpr int steps = 4;
  if (!simulation->advance(first).reached()) return;
  const std::int64_t before = simulation->map_steps();
  const double rate = std::abs(scene->step()) / scene->substeps() * simulation->rate();
  measured_steps(*simulation, steps);
  const auto& method = scene->description().method;
  std::cout << scene->system() << ' ' << (method ? scene->method() : "-") << ' ' << scene->order()
            << ' ' << (method ? method->arithmetic : "compensated") << ' '
            << (method ? method->scalar : "double") << ' ' << size.n << ' ' << size.N << ' '
            << simulation->map_steps() - before << ' ' << rate << ' ' << step_price(*scene, rate)
            << std::endl;
}

/// Counts a method in every size.
void count(std::string_view system, std::string_view method, std::optional<int> order,
           const char* arithmetic, const char* scalar) {
  const std::string of(system), by(method);
  const auto at = [&](Size size, double rate) {
    SceneDescription d = bench::sized_scene(of, by, size, 1, rate);
    if (!by.empty()) d.method = MethodDescription{by, order, 1, arithmetic, {}, scalar};
    count(std::move(d), size);
  };
  const bool in_float = scalar == std::string("float");
  for (const Size size : sizes(of, by, order.value_or(0)))
    if (size.N == 3 || !in_float) at(size, h_Omega);
  if (!by.empty() && catalogue().method(by)->default_tolerance > 0) return;
  for (const Size size : sizes_for_rates(of, by, order.value_or(0)))
    for (const double rate : other_rates)
      if (size.N == 3 || !in_float) at(size, rate);
}

/// Counts every method of a system, or `only` one, in every order, arithmetic and scalar. Closed
/// forms and discrete systems have neither.
void count(const SystemInfo& system, std::string_view only) {
  if (system.discrete) return count(system.name, "", std::nullopt, "compensated", "double");
  for (const auto& on : system.methods) {
    if (!only.empty() && on.method != only) continue;
    const auto& orders = catalogue().method(on.method)->orders;
    for (const int order : orders)
      for (const char* arithmetic : {"compensated", "plain"}) {
        count(system.name, on.method, order, arithmetic, "double");
        if (on.in_float) count(system.name, on.method, order, arithmetic, "float");
      }
    if (orders.empty()) count(system.name, on.method, std::nullopt, "compensated", "double");
  }
}

/// Counts steps of as many bodies as fit into a vector register, from which the price of an
/// ensemble is computed (step_weight.h, pack_price). The steps are so many that the rest of a call
/// does not matter.
void count_pack(SceneDescription one, bool frame, double rate) {
  constexpr std::int64_t steps = 256;
  std::vector<SceneDescription> bodies;
  const int N = static_cast<int>(one.inertia.size());
  const bool in_float = one.method && one.method->scalar == "float";
  for (unsigned seed = 1; seed <= (in_float ? 8u : 4u); ++seed) {
    SceneDescription body = testing::any_scene(one.system, "", seed, rate, N);
    body.method = one.method;
    if (!frame) body.initial.erase("Q");
    bodies.push_back(std::move(body));
  }
  const auto scene = Scene::resolve(testing::ensemble_of(bodies));
  if (!scene || !can_be_packed(*scene)) return;
  const auto simulation = make_simulation(*scene);
  if (!simulation->advance(1).reached()) return;
  const double h_omega = std::abs(scene->step()) * simulation->rate();
  measured_steps(*simulation, steps);
  const auto& method = scene->description().method;
  std::cout << "packed_" << scene->system() << (frame ? "" : "_momentum") << ' '
            << (method ? scene->method() : "-") << ' ' << scene->order() << ' '
            << (method ? method->arithmetic : "compensated") << ' '
            << (method ? method->scalar : "double") << ' ' << N << ' ' << N << ' ' << steps << ' '
            << h_omega << ' ' << pack_price(scene->members().front()).value_or(0) << std::endl;
}

void count_packs(const SystemInfo& system, bool frame) {
  const auto in_every_size = [&](SceneDescription one) {
    one.system = system.name;
    for (const int N : {3, 4}) {
      one.inertia.resize(static_cast<std::size_t>(N));
      count_pack(one, frame, h_Omega);
      if (one.method && counts_repeat(one.method->name)) continue;
      for (const double rate : other_rates) count_pack(one, frame, rate);
    }
  };
  if (system.discrete) return in_every_size({});
  for (const auto& on : system.methods)
    for (const int order : catalogue().method(on.method)->orders)
      for (const char* arithmetic : {"compensated", "plain"})
        for (const char* scalar : {"double", "float"}) {
          SceneDescription one;
          one.method = MethodDescription{std::string(on.method), order, 1, arithmetic, {}, scalar};
          in_every_size(std::move(one));
        }
}

}  // namespace

int main(int argc, char** argv) {
  for (const auto& system : catalogue().systems) {
    const std::string packed = "packed_" + std::string(system.name), alone = packed + "_momentum";
    const bool in_packs = system_entry(system.name)->packs;
    if (argc == 1)
      std::cout << system.name << '\n' << (in_packs ? packed + "\n" + alone + "\n" : "");
    else if (system.name == argv[1])
      count(system, argc > 2 ? argv[2] : "");
    else if (in_packs && argc == 2 && (argv[1] == packed || argv[1] == alone))
      count_packs(system, argv[1] == packed);
  }
}
