#include <dlfcn.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "stiefel/catalogue.h"
#include "stiefel/crew.h"
#include "stiefel/simulation.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_scene.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {
std::atomic<long> allocations = 0;
}

/// Eigen and operator new both call this function.
extern "C" void* malloc(std::size_t size) {
  using Malloc = void* (*)(std::size_t);
  static const auto next = reinterpret_cast<Malloc>(dlsym(RTLD_NEXT, "malloc"));
  allocations.fetch_add(1, std::memory_order_relaxed);
  return next(size);
}

namespace stiefel {
namespace {

long allocations_in_steps(const Scene& scene) {
  const auto simulation = make_simulation(scene);
  EXPECT_TRUE(simulation->advance(1).reached());
  const long before = allocations;
  EXPECT_TRUE(simulation->advance(5).reached());
  return allocations - before;
}

/// On one thread. A pass that several threads share allocates once: a step of gauss4 with N = 64
/// has one.
TEST(Allocation, NoneAfterTheFirstStep) {
  limit_threads(1);
  for (const auto& method : catalogue().system("rigid_body")->methods)
    for (const int N : {3, 8, 64})
      for (const char* arithmetic : {"compensated", "plain"}) {
        if (method.takes && !method.takes(Eigen::VectorXd::LinSpaced(N, 1, 2))) continue;
        EXPECT_EQ(allocations_in_steps(
                      testing::random_scene(N, 1, 0.05, std::string(method.method), arithmetic)),
                  0)
            << method.method << " " << arithmetic << " N=" << N;
      }
}

TEST(Allocation, NoneInAnySystem) {
  for (const auto& system : catalogue().systems)
    for (const auto& method : system.methods) {
      const int N = method.takes && !method.takes(Eigen::VectorXd::Ones(4)) ? 3 : 4;
      const auto scene = Scene::resolve(
          testing::any_scene(std::string(system.name), std::string(method.method), 1, 0.05, N));
      EXPECT_EQ(allocations_in_steps(scene.value()), 0) << system.name << " " << method.method;
    }
}

TEST(Allocation, TheCounterCounts) {
  const long before = allocations;
  free(malloc(10));
  EXPECT_EQ(allocations - before, 1);
}

}  // namespace
}  // namespace stiefel

#endif
