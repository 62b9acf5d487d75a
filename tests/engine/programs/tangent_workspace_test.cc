// The predicted bytes of tangents, against the most that malloc has given out at a time.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <cstdlib>

#include "stiefel/catalogue.h"
#include "stiefel/linearization.h"
#include "stiefel/lyapunov.h"
#include "stiefel/price.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"

namespace {

std::atomic<std::ptrdiff_t> held = 0, most_held = 0;

void* taken(void* memory) {
  const auto now = held += static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  for (auto most = most_held.load(); now > most && !most_held.compare_exchange_weak(most, now);) {
  }
  return memory;
}

}  // namespace

// What Eigen, operator new and the compiler's code call.
extern "C" void* malloc(std::size_t size) {
  static const auto next = reinterpret_cast<void* (*)(std::size_t)>(dlsym(RTLD_NEXT, "malloc"));
  return taken(next(size));
}
extern "C" void* calloc(std::size_t count, std::size_t size) {
  static const auto next =
      reinterpret_cast<void* (*)(std::size_t, std::size_t)>(dlsym(RTLD_NEXT, "calloc"));
  return taken(next(count, size));
}
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) {
  static const auto next =
      reinterpret_cast<void* (*)(std::size_t, std::size_t)>(dlsym(RTLD_NEXT, "aligned_alloc"));
  return taken(next(alignment, size));
}
extern "C" void* realloc(void* memory, std::size_t size) {
  static const auto next =
      reinterpret_cast<void* (*)(void*, std::size_t)>(dlsym(RTLD_NEXT, "realloc"));
  held -= static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  return taken(next(memory, size));
}
extern "C" void free(void* memory) {
  static const auto next = reinterpret_cast<void (*)(void*)>(dlsym(RTLD_NEXT, "free"));
  held -= static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  next(memory);
}

namespace stiefel {
namespace {

/// Objects beside matrices.
constexpr double slack = 256 << 10;

/// Returns the most bytes that `work` holds at a time.
double most_bytes(const auto& work) {
  const std::ptrdiff_t before = held;
  most_held = before;
  work();
  return static_cast<double>(most_held - before);
}

SceneDescription frames(Eigen::Index n, Eigen::Index N, const std::string& method) {
  const testing::RandomFrame<double> frame(static_cast<int>(n), static_cast<int>(N), 1, 4);
  SceneDescription scene;
  scene.system = "stiefel";
  scene.method = MethodDescription{method, std::nullopt, std::nullopt, ""};
  scene.step = 1e-3;
  scene.inertia.assign(frame.lambda.begin(), frame.lambda.end());
  scene.initial["Q"] = Block(RowMatrix(frame.Q));
  scene.initial["S"] = Block(RowMatrix(frame.S));
  return scene;
}
SceneDescription body(int N, const char* method) {
  return testing::description(testing::RandomBody(N, 1), 1e-3, method);
}

/// Not below what is held, and at most `most` times it.
void expect_price(std::uint64_t priced, double actual, const std::string& what, double most = 3) {
  EXPECT_GE(static_cast<double>(priced), actual) << what;
  EXPECT_LE(static_cast<double>(priced), most * actual + slack) << what;
}

std::int64_t size_of(const Scene& scene) {
  std::int64_t size = 0;
  for (const auto& [name, block] : scene.description().initial)
    size += static_cast<std::int64_t>(block.values.size() + block.imaginary.size());
  return size;
}

/// All vectors where `m` is 0.
void expect_linearization(SceneDescription description, Eigen::Index m, const std::string& what,
                          double most = 3) {
  const auto resolved = Scene::resolve(std::move(description));
  if (!resolved) {  // a method for three dimensions
    EXPECT_TRUE(resolved.error().front().field.starts_with("method")) << what;
    return;
  }
  const Scene& scene = *resolved;
  const auto motion = make_simulation(scene);
  Eigen::Index count = 0;
  LinearizationDescription given;
  if (m > 0) {
    Eigen::MatrixXd x(2 * motion->get("Q").rows(), scene.dimension());
    x << Eigen::MatrixXd::Zero(x.rows() / 2, x.cols()), motion->get("S");
    given.vectors = x.reshaped<Eigen::RowMajor>().replicate(1, m);
    given.as_blocks = true;
  }
  bool made = true;
  const double actual = most_bytes([&] {
    auto tangent = Linearization::make(scene, std::move(given), *motion);
    made = tangent.has_value();
    if (!made) return;
    EXPECT_TRUE(tangent->advance(*motion, 2).reached());
    count = tangent->vectors(*motion).cols();
  });
  if (!made) return;
  expect_price(linearization_bytes(scene, m > 0 ? m : size_of(scene), m == 0), actual,
               what + " " + std::to_string(count) + " vectors", most);
}

TEST(TangentWorkspace, OfAMatrix) {
  for (const char* method : {"variational", "rk4", "munthe_kaas4", "gauss4", "implicit_midpoint"})
    for (const int N : {3, 5, 8, 12, 20})
      expect_linearization(body(N, method), 0, std::string(method) + " N = " + std::to_string(N));
  for (const char* method : {"variational", "rk4", "munthe_kaas4"})
    for (const auto& [n, N] : {std::pair{1, 8}, {2, 5}, {3, 16}, {8, 16}})
      expect_linearization(
          frames(n, N, method), 0,
          std::string(method) + " V(" + std::to_string(n) + ", " + std::to_string(N) + ")");
  for (const SystemInfo& system : catalogue().systems) {
    const std::string name(system.name);
    // The tangent spaces of some have fewer directions than their blocks show: half as many, and of
    // the reduced body, whose P follows from Q, a quarter.
    const double most = name == "reduced_rigid_body" ? 12 : 4;
    if (system.discrete)
      expect_linearization(testing::any_scene(name, "", 1, 0.02, 8), 0, name, most);
    for (const MethodOnSystem& on : system.methods)
      if (!on.takes)  // the closed forms, whose Λ is special
        expect_linearization(testing::any_scene(name, std::string(on.method), 1, 0.02, 8), 0,
                             name + " " + std::string(on.method), most);
  }
}

TEST(TangentWorkspace, OfSomeVectorsOfLargeFrames) {
  for (const auto& [n, N] : {std::pair{4, 1000}, {4, 100'000}, {8, 1000}, {2, 20'000}})
    for (const Eigen::Index m : {1, 4, 16})
      expect_linearization(frames(n, N, "variational"),
                           N > 20'000 ? std::min<Eigen::Index>(m, 4) : m,
                           "V(" + std::to_string(n) + ", " + std::to_string(N) + ")");
}

TEST(TangentWorkspace, OfSpectra) {
  const auto expect = [](SceneDescription description, const LyapunovDescription& what,
                         const std::string& name) {
    const Scene scene = Scene::resolve(std::move(description)).value();
    const auto motion = make_simulation(scene);
    const double actual = most_bytes([&] {
      auto spectrum = LyapunovExponents::make(scene, what, *motion);
      ASSERT_TRUE(spectrum) << name << " " << spectrum.error().front().rule;
      EXPECT_TRUE(spectrum->advance(*motion, what.to).reached());
    });
    expect_price(lyapunov_bytes(scene, what, size_of(scene)), actual, name);
  };
  for (const int N : {3, 5, 8, 12, 20})
    for (const std::int64_t count : {0, 2})
      expect(body(N, "variational"), {.to = 20, .count = count, .interval = 1},
             "N = " + std::to_string(N) + ", count " + std::to_string(count));
  for (const auto& [n, N] : {std::pair{1, 8}, {2, 5}, {3, 16}})
    expect(frames(n, N, "variational"), {.to = 40, .interval = 2},
           "V(" + std::to_string(n) + ", " + std::to_string(N) + ")");
}

}  // namespace
}  // namespace stiefel
