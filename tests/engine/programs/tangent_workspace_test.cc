// The predicted bytes of tangents, against the most that malloc has given out at a time.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
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
constexpr double tangent_slack = 256 << 10;

/// Returns the most bytes that `work` holds at a time.
double most_bytes(const auto& work) {
  const std::ptrdiff_t before = held;
  most_held = before;
  work();
  return static_cast<double>(most_held - before);
}

SceneDescription frames(Eigen::Index n, Eigen::Index N) {
  const testing::RandomFrame<double> frame(static_cast<int>(n), static_cast<int>(N), 1, 4);
  SceneDescription scene;
  scene.system = "stiefel";
  scene.method = MethodDescription{"variational", std::nullopt, std::nullopt, ""};
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
  EXPECT_LE(static_cast<double>(priced), most * actual + tangent_slack) << what;
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
    EXPECT_TRUE((*tangent)->advance(*motion, 2).reached());
    count = (*tangent)->vectors(*motion).cols();
  });
  if (!made) return;
  expect_price(linearization_bytes(scene, m > 0 ? m : size_of(scene), m == 0), actual,
               what + " " + std::to_string(count) + " vectors", most);
}

TEST(TangentWorkspace, OfAMatrix) {
  for (const char* method : {"exact", "variational", "preprocessed_variational", "rk4"})
    for (const int N : {3, 5, 8, 12, 20})
      expect_linearization(body(N, method), 0, std::string(method) + " N = " + std::to_string(N));
  for (const auto& [n, N] : {std::pair{1, 8}, {2, 5}, {3, 16}, {8, 16}})
    expect_linearization(frames(n, N), 0,
                         "V(" + std::to_string(n) + ", " + std::to_string(N) + ")");
  // The tangent spaces have half as many directions as their blocks show.
  for (const SystemInfo& system : catalogue().systems)
    if (const std::string name(system.name); system.discrete && system.methods.front().has_tangent)
      expect_linearization(testing::any_scene(name, "", 1, 0.02, 8), 0, name, 4);
}

TEST(TangentWorkspace, OfSomeVectorsOfLargeFrames) {
  for (const auto& [n, N] : {std::pair{4, 1000}, {4, 100'000}, {8, 1000}, {2, 20'000}})
    for (const Eigen::Index m : {1, 4, 16})
      expect_linearization(frames(n, N), N > 20'000 ? std::min<Eigen::Index>(m, 4) : m,
                           "V(" + std::to_string(n) + ", " + std::to_string(N) + ")");
}

TEST(TangentWorkspace, OfSpectra) {
  // The price counts the second motion, which unstable rotations have.
  const auto expect = [](SceneDescription description, const LyapunovDescription& what,
                         const std::string& name, bool has_second = false) {
    const Scene scene = Scene::resolve(std::move(description)).value();
    const auto motion = make_simulation(scene);
    const double actual = most_bytes([&] {
      auto spectrum = LyapunovExponents::make(scene, what, *motion);
      ASSERT_TRUE(spectrum) << name << " " << spectrum.error().front().rule;
      std::string saved;
      while (!(*spectrum)->done()) {
        EXPECT_TRUE((*spectrum)->advance(*motion, what.to).reached());
        saved = (*spectrum)->save();
      }
      EXPECT_EQ(has_second, (*spectrum)->reason().contains("beside this one")) << name;
    });
    const auto priced = lyapunov_bytes(scene, what, size_of(scene));
    if (has_second)
      expect_price(priced, actual, name);
    else
      EXPECT_GE(static_cast<double>(priced), actual) << name;
  };
  for (const int N : {3, 5, 8}) {
    SceneDescription unstable = body(N, "variational");
    std::ranges::sort(unstable.inertia);
    RowMatrix& M = unstable.initial["M"].values;
    M.setZero();
    M(0, N - 1) = 1;
    M(N - 1, 0) = -1;
    unstable.step = 0.3;
    expect(unstable, {.to = 6000, .count = 2}, "unstable, N = " + std::to_string(N), true);
  }
  for (const int N : {3, 5, 8, 12, 20})
    for (const std::int64_t count : {0, 2})
      expect(body(N, "variational"), {.to = 20, .count = count, .interval = 1},
             "N = " + std::to_string(N) + ", count " + std::to_string(count));
  for (const auto& [n, N] : {std::pair{1, 8}, {2, 5}, {3, 16}})
    expect(frames(n, N), {.to = 40, .interval = 2},
           "V(" + std::to_string(n) + ", " + std::to_string(N) + ")");
}

}  // namespace
}  // namespace stiefel
