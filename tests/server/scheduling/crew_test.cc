// The parts of a call that helpers compute in idle places.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <stdexcept>
#include <thread>
#include <vector>

#include "server/scheduling/helpers.h"

namespace stiefel::server {
namespace {

/// The turn and the crew of a call.
struct Computing {
  explicit Computing(int places) : turns(places), helpers(turns, places - 1) {}

  void share_out(std::size_t count, double nanoseconds,
                 const std::function<void(std::size_t)>& item) {
    crew.run(
        count, nanoseconds,
        [](void* context, std::size_t i) {
          (*static_cast<const std::function<void(std::size_t)>*>(context))(i);
        },
        const_cast<std::function<void(std::size_t)>*>(&item));
  }

  Turns turns;
  Helpers helpers;
  Turns::Share share;
  std::stop_source stop;
  Turns::OfCall turn{turns, share, stop, [] { return false; }};
  Helpers::OfCall crew{helpers, turn};
};

TEST(Crew, EveryItemIsDoneOnce) {
  Computing call(4);
  for (const std::size_t count : {1u, 2u, 3u, 100u, 10'000u}) {
    for (const double nanoseconds : {1.0, 1e6, 1e9}) {
      std::vector<std::atomic<int>> times(count);
      call.share_out(count, nanoseconds, [&](std::size_t i) { ++times[i]; });
      EXPECT_TRUE(std::ranges::all_of(times, [](const auto& n) { return n == 1; })) << count;
    }
  }
}

/// The only helper is inside an item when another call wants a place: it leaves after that item.
TEST(Crew, AHelperLeavesForACallThatWaits) {
  Computing call(2);
  std::stop_source stop;
  Turns::Share share;
  Turns::OfCall first(call.turns, share, stop, [] { return false; }),
      second(call.turns, share, stop, [] { return false; });
  std::atomic<bool> has_place = false;
  std::jthread other;
  const auto leader = std::this_thread::get_id();
  std::this_thread::sleep_for(Turns::short_time);
  first.pass();  // one place of two
  while (!has_place) {
    call.share_out(1000, 1e8, [&](std::size_t) {
      std::this_thread::sleep_for(std::chrono::microseconds(10));
      if (std::this_thread::get_id() != leader && !other.joinable())
        other = std::jthread([&] {
          second.pass();
          has_place = true;
        });
    });
  }
}

TEST(Crew, OneThreadDividesNothing) {
  Computing call(1);
  EXPECT_EQ(call.crew.threads_at_hand(), 1u);
  const auto here = std::this_thread::get_id();
  call.share_out(20, 1e8, [&](std::size_t) { EXPECT_EQ(std::this_thread::get_id(), here); });
}

TEST(Crew, WhatAnItemThrowsIsThrown) {
  Computing call(2);
  EXPECT_THROW(call.share_out(100, 1e9,
                              [](std::size_t i) {
                                if (i % 2) throw std::runtime_error("an item");
                              }),
               std::runtime_error);
}

}  // namespace
}  // namespace stiefel::server
