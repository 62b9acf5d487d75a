// Calls that several threads share: the crew of the library, and the bits of what it divides.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <latch>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "engine/dense/decompositions.h"
#include "engine/frame/blocked_pass.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"
#include "tests/support/sanitizer.h"
#include "tests/support/saved.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/every_pair.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/resolved.h"

namespace stiefel {
namespace {

using testing::resolved;
using testing::saved;

/// Sets the threads of the library while it lives.
class Threads {
 public:
  explicit Threads(int count) { limit_threads(count); }
  ~Threads() { limit_threads(static_cast<int>(std::thread::hardware_concurrency())); }
};

TEST(Team, EveryItemIsDoneOnceByTheLeaderAndItsHelpers) {
  Team team;
  std::atomic<bool> end = false;
  std::vector<std::jthread> helpers;
  for (int k = 0; k < 3; ++k)
    helpers.emplace_back([&] {
      while (!end) team.help([&] { return end.load(); }, [] { return 1.0; });
    });
  std::vector<std::atomic<int>> times(1000);
  const auto count = [](void* all, std::size_t i) {
    ++(*static_cast<std::vector<std::atomic<int>>*>(all))[i];
  };
  for (int run = 0; run < 2000; ++run) team.run(times.size(), 1 + run % 7, count, &times);
  end = true;
  EXPECT_TRUE(std::ranges::all_of(times, [](const auto& n) { return n == 2000; }));
}

TEST(Team, AHelperLeavesForWantOfWorkAndWhenItIsTold) {
  Team team;
  EXPECT_TRUE(team.help([] { return false; }, [] { return 0.0; }));
  int looks = 0;
  EXPECT_FALSE(team.help([&] { return ++looks == 3; }, [] { return 0.0; }));
}

TEST(Team, WhatHelpersDoIsMetered) {
  Team team;
  std::latch joined(1);
  std::atomic<bool> end = false;
  const std::jthread helper([&] {
    double work = 0;
    while (!end) team.help([&] { return end.load(); }, [&] { return work += 5; });
  });
  double all = 0;
  while (all == 0) {
    team.run(
        100, 1,
        [](void*, std::size_t) { std::this_thread::sleep_for(std::chrono::microseconds(10)); },
        nullptr);
    all += team.take_helpers_work();
  }
  EXPECT_EQ(std::fmod(all, 5), 0);
  EXPECT_EQ(team.take_helpers_work(), 0);
  end = true;
}

/// One thread takes the items in order, so that those after the one that throws are not called.
TEST(Team, WhatAnItemThrowsIsThrownAndEndsTheRun) {
  for (const int threads : {4, 1}) {
    const Threads some(threads);
    std::atomic<int> done = 0;
    EXPECT_THROW(share_out(*crew_to_divide(), 1000, 1e9,
                           [&](std::size_t i) {
                             ++done;
                             if (i == 10) throw std::runtime_error("an item");
                           }),
                 std::runtime_error);
    if (threads == 1) {
      EXPECT_EQ(done, 11);
    }
  }
}

TEST(Crew, WhatAnItemDividesItDoesItself) {
  const Threads four(4);
  std::atomic<int> divided = 0;
  share_out(*crew_to_divide(), 64, 1e9,
            [&](std::size_t) { divided += crew_to_divide() != nullptr; });
  EXPECT_EQ(divided, 0);
  EXPECT_NE(crew_to_divide(), nullptr);
}

TEST(Crew, SeveralLeadersAtOnceGetTheirOwnItems) {
  const Threads four(4);
  std::vector<std::jthread> leaders;
  std::atomic<int> wrong = 0;
  for (int leader = 0; leader < 4; ++leader)
    leaders.emplace_back([&] {
      std::vector<int> times(300);
      for (int run = 0; run < 300; ++run)
        share_out(*crew_to_divide(), times.size(), 1e6, [&](std::size_t i) { ++times[i]; });
      wrong += !std::ranges::all_of(times, [](int n) { return n == 300; });
    });
  leaders.clear();
  EXPECT_EQ(wrong, 0);
}

TEST(Crew, NeverHasMoreThreadsThanItsLimit) {
  for (const int limit : {1, 2, 3, 1, 3, 2}) {
    const Threads some(limit);
    std::atomic<int> working = 0, at_most = 0;
    share_out(*crew_to_divide(), 200, 1e9, [&](std::size_t) {
      const int now = ++working;
      for (int seen = at_most; now > seen && !at_most.compare_exchange_weak(seen, now);) {
      }
      std::this_thread::sleep_for(std::chrono::microseconds(50));
      --working;
    });
    EXPECT_LE(at_most, limit);
  }
}

template <class Scalar>
Matrix<Scalar> random_matrix(Eigen::Index rows, Eigen::Index columns) {
  return Eigen::MatrixXd::Random(rows, columns).cast<Scalar>() +
         Eigen::MatrixXd::Random(rows, columns).cast<Scalar>() * two_to<Scalar>(-20);
}

template <class Scalar>
class Divided : public ::testing::Test {};
using Scalars = ::testing::Types<double, long double>;
TYPED_TEST_SUITE(Divided, Scalars);

/// Whether `compute(C)` gives one C on one thread and on `threads`.
template <class Scalar, class Compute>
bool same_on_one(int threads, const Compute& compute) {
  Matrix<Scalar> whole, parts;
  {
    const Threads one(1);
    compute(whole);
  }
  const Threads some(threads);
  compute(parts);
  return parts == whole;
}

TYPED_TEST(Divided, ProductsHaveTheBitsOfThoseInOnePiece) {
  using Scalar = TypeParam;
  using Dense = Matrix<Scalar>;
  const auto sizes =
      std::is_same_v<Scalar, long double>
          ? std::vector<Eigen::Index>{129, 250}
          : std::vector<Eigen::Index>{128, 129, 130, 131, 187, 250, 256, 403, 514, 699};
  for (const int threads : {2, 3, 8})
    for (const Eigen::Index N : sizes) {
      const Dense A = random_matrix<Scalar>(N, N), B = random_matrix<Scalar>(N, N);
      const auto same = [&](const auto& compute) { return same_on_one<Scalar>(threads, compute); };
      EXPECT_TRUE(same([&](Dense& C) { C.noalias() = A * B; })) << N << " on " << threads;
      EXPECT_TRUE(same([&](Dense& C) { C.noalias() = A.transpose() * B; }))
          << N << " on " << threads;
      EXPECT_TRUE(same([&](Dense& C) {
        C = B;
        C.noalias() += Scalar(0.3) * A * B.transpose();
      })) << N
          << " on " << threads;
      if constexpr (std::is_same_v<Scalar, double>) {
        EXPECT_TRUE(same([&](Dense& C) {
          C = Dense::Zero(N, N);
          upper_gram(A, C);
        })) << N
            << " on " << threads;
      }
      EXPECT_TRUE(same([&](Dense& C) { Lu<Scalar>(A).solve(B, C); })) << N << " on " << threads;
    }
}

TEST(Divided, WideAndFlatProductsHaveTheBitsOfThoseInOnePiece) {
  for (const Eigen::Index n : {2, 4, 17})
    for (const Eigen::Index N : {20'000, 600'001}) {
      const Eigen::MatrixXd A = random_matrix<double>(n, n), B = random_matrix<double>(n, N);
      EXPECT_TRUE(same_on_one<double>(3, [&](Eigen::MatrixXd& C) { C.noalias() = A * B; }))
          << n << " " << N;
    }
}

std::vector<double> after(const Scene& scene, int steps, int threads) {
  const Threads some(threads);
  const auto simulation = make_simulation(scene);
  EXPECT_TRUE(simulation->advance(steps).reached());
  return saved(*simulation);
}

void has_one_set_of_bits(const SceneDescription& description, int steps, const std::string& what) {
  const Scene scene = resolved(description);
  const std::vector<double> alone = after(scene, steps, 1);
  for (const int threads : {2, 3, 8})
    EXPECT_EQ(after(scene, steps, threads), alone) << what << " on " << threads;
}

/// Bodies of every system and method, above the least order that is divided.
TEST(Threads, ALargeBodyHasTheSameBitsOnAnyNumberOfThem) {
  if (testing::sanitized) GTEST_SKIP() << "takes minutes";
  constexpr int N = 133;
  std::set<std::string> done;
  for (const testing::Pair& pair : testing::every_pair()) {
    const bool rigid = pair.system.find("stiefel") == std::string::npos &&
                       pair.system.find("double_bracket") == std::string::npos &&
                       pair.system.find("parametric") == std::string::npos &&
                       pair.system != "ellipsoid";
    if (!rigid || pair.N == 3 || !done.insert(pair.system + " " + pair.method).second) continue;
    SceneDescription scene = testing::any_scene(pair.system, pair.method, 3, 0.05, N);
    has_one_set_of_bits(scene, 1, pair.system + " " + pair.method);
  }
  EXPECT_GE(done.size(), 30u);
}

TEST(Threads, AVariationalBodyHasTheSameBitsOnAnyNumberOfThem) {
  for (const char* arithmetic : {"plain", "compensated"})
    for (const double spread : {4.0, 1000.0})
      has_one_set_of_bits(
          testing::description(testing::RandomBody(256, 1, spread), 0.1, "variational", arithmetic),
          spread > 4 ? 1 : 12, arithmetic);
  SceneDescription high = testing::description(testing::RandomBody(150, 1), 0.1, "variational");
  high.method->order = 6;
  has_one_set_of_bits(high, 2, "order 6");
}

SceneDescription frame(int n, int N, const char* arithmetic, int order) {
  const testing::RandomFrame<double> at(n, N, 1);
  SceneDescription d;
  d.system = n == 1 ? "ellipsoid" : "stiefel";
  d.method = {"variational", order, 1, arithmetic};
  d.inertia = {at.lambda.begin(), at.lambda.end()};
  d.initial[n == 1 ? "q" : "Q"] = at.Q;
  if (n == 1)
    d.initial["qdot"] = RowMatrix(at.S * at.lambda.cwiseInverse().asDiagonal());
  else
    d.initial["S"] = at.S;
  d.step = 0.1;
  return d;
}

TEST(Threads, ALongFrameHasTheSameBitsOnAnyNumberOfThem) {
  for (const char* arithmetic : {"plain", "compensated"}) {
    has_one_set_of_bits(frame(4, 100'000, arithmetic, 2), 3, arithmetic);
    has_one_set_of_bits(frame(3, 20'000, arithmetic, 4), 2, arithmetic);
    has_one_set_of_bits(frame(7, 9'000, arithmetic, 2), 2, arithmetic);
    has_one_set_of_bits(frame(2, 30'001, arithmetic, 2), 3, arithmetic);
    has_one_set_of_bits(frame(1, 20'000, arithmetic, 2), 3, arithmetic);
  }
}

/// Up to the size of a block the moments are those of one pass over all columns; above it they are
/// as near to it as the rounding of sums allows.
TEST(BlockedPass, IsOnePassUpToTheSizeOfABlock) {
  for (const Eigen::Index N : {100, 4096, 4097, 50'000}) {
    const int n = 3;
    testing::RandomFrame<double> at(n, static_cast<int>(N), 1);
    Eigen::MatrixXd x = at.state();
    Eigen::VectorXd inverse = Eigen::VectorXd::Zero(N + FramePass<double>::width);
    inverse.head(N) = at.lambda.cwiseInverse();
    const FrameColumns<double> columns{x.data(), nullptr, inverse.data(), N};
    FrameMoments<double> whole(n), blocked(n);
    make_frame_pass<double>(Arithmetic::plain, n)
        ->advance(columns, 0, nullptr, nullptr, whole.sums());
    BlockedPass<double>(Arithmetic::plain, n, N).advance(columns, 0, nullptr, nullptr, blocked);
    const auto near = [&](const auto& a, const auto& b) {
      for (std::size_t p = 0; p < a.size(); ++p)
        EXPECT_LE((a[p] - b[p]).cwiseAbs().maxCoeff(), N <= 4096 ? 0 : 1e-14) << N;
    };
    near(whole.QQ, blocked.QQ);
    near(whole.QV, blocked.QV);
    near(whole.VV, blocked.VV);
  }
}

/// Stopped within a step that threads share, a simulation is where it was.
TEST(Threads, AStepOfALargeBodyIsStoppedInside) {
  const Threads three(3);
  const Scene scene =
      resolved(testing::description(testing::RandomBody(300, 1), 0.1, "munthe_kaas4"));
  const auto stopped = make_simulation(scene), undisturbed = make_simulation(scene);
  ASSERT_TRUE(undisturbed->advance(2).reached());
  ASSERT_TRUE(stopped->advance(1).reached());
  const auto before = saved(*stopped);
  for (const int milliseconds : {1, 5, 20}) {
    std::stop_source source;
    const std::jthread later([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
      source.request_stop();
    });
    const RunStatus status = stopped->advance(1'000'000, source.get_token());
    EXPECT_EQ(status.outcome, Outcome::cancelled);
    stopped->restore(1, before);
  }
  ASSERT_TRUE(stopped->advance(1).reached());
  EXPECT_EQ(saved(*stopped), saved(*undisturbed));
}

}  // namespace
}  // namespace stiefel
