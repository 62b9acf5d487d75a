// Who computes, and when: with a clock that the tests advance.
#include "server/scheduling/turns.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "server/scheduling/helpers.h"

namespace stiefel::server {
namespace {

using namespace std::chrono_literals;

std::atomic<Turns::Clock::duration> passed = 0ns;
Turns::Clock::time_point now() { return Turns::Clock::time_point(passed.load()); }
void compute(Turns::Clock::duration time) { passed = passed.load() + time; }

void wait_until(const auto& is_so) {
  while (!is_so()) std::this_thread::yield();
}

/// A call of a principal, whose stop points tests pass.
struct Caller {
  Caller(Turns& turns, Turns::Share& share)
      : all(turns), turn(turns, share, stop, [this] { return left.load(); }) {}

  /// Passes a stop point on a thread of its own.
  void start() {
    thread = std::jthread([this] {
      turn.pass();
      went_on = true;
    });
  }
  /// Begins a call on a thread of its own, and returns once it waits for a place.
  void wait_for_place() {
    const std::size_t before = all.waiting();
    start();
    wait_until([&] { return went_on || all.waiting() > before; });
  }

  Turns& all;
  std::stop_source stop;
  std::atomic<bool> left = false, went_on = false;
  Turns::OfCall turn;
  std::jthread thread;
};

/// A call that has computed for `time`, without a place.
std::unique_ptr<Caller> caller_after(Turns::Clock::duration time, Turns& turns,
                                     Turns::Share& share) {
  auto caller = std::make_unique<Caller>(turns, share);
  compute(time);
  caller->turn.pass();
  caller->turn.give();
  return caller;
}

TEST(Turns, TheFirstMomentsAreFree) {
  Turns turns(1, &now);
  Turns::Share share;
  Caller caller(turns, share);
  compute(Turns::free_time - 1us);
  caller.turn.pass();
  EXPECT_EQ(turns.idle(), 1);
  compute(1us);
  caller.turn.pass();
  EXPECT_EQ(turns.idle(), 0);
  caller.turn.give();
  EXPECT_EQ(turns.idle(), 1);
  EXPECT_EQ(turns.computed(), Turns::free_time);
}

TEST(Turns, ACallGivesItsPlaceAfterATurn) {
  Turns turns(1, &now);
  Turns::Share share;
  const auto first = caller_after(1s, turns, share), second = caller_after(1s, turns, share);
  first->turn.pass();
  second->wait_for_place();
  compute(Turns::turn - Turns::look);
  first->turn.pass();
  EXPECT_FALSE(second->went_on);
  compute(Turns::look);
  first->start();
  wait_until([&] { return second->went_on.load(); });
  EXPECT_FALSE(first->went_on);
  second->turn.give();
  wait_until([&] { return first->went_on.load(); });
}

TEST(Turns, AShortCallHasOnePlaceMore) {
  Turns turns(1, &now);
  Turns::Share share;
  const auto endless = caller_after(1s, turns, share);
  endless->turn.pass();
  const auto brief = std::make_unique<Caller>(turns, share),
             next = std::make_unique<Caller>(turns, share);
  compute(Turns::free_time);
  brief->turn.pass();  // at once
  next->wait_for_place();
  EXPECT_FALSE(next->went_on);
  brief->turn.give();
  wait_until([&] { return next->went_on.load(); });
}

TEST(Turns, OfOneShareTheCallThatHasComputedLeastGoesFirst) {
  Turns turns(1, &now);
  Turns::Share share;
  const auto running = caller_after(1s, turns, share), endless = caller_after(1s, turns, share),
             other = caller_after(4ms, turns, share), medium = caller_after(4ms, turns, share);
  running->turn.pass();
  other->turn.pass();  // in the place more
  endless->wait_for_place();
  medium->wait_for_place();
  running->turn.give();
  other->turn.give();
  wait_until([&] { return medium->went_on.load(); });
  EXPECT_FALSE(endless->went_on);
  medium->turn.give();
  wait_until([&] { return endless->went_on.load(); });
}

TEST(Turns, PrincipalsHaveEqualShares) {
  Turns turns(1, &now);
  Turns::Share greedy, modest;
  const auto running = caller_after(1s, turns, greedy), second = caller_after(1s, turns, greedy),
             other = caller_after(1s, turns, modest);
  running->turn.pass();
  second->wait_for_place();
  other->wait_for_place();
  compute(2 * Turns::lead);
  running->turn.give();
  wait_until([&] { return other->went_on.load(); });
  EXPECT_FALSE(second->went_on);
  compute(4 * Turns::lead);
  other->turn.give();
  wait_until([&] { return second->went_on.load(); });
}

TEST(Turns, ACallWhoseCallerLeftWaitsNoMore) {
  Turns turns(1, &now);
  Turns::Share share;
  const auto running = caller_after(1s, turns, share), gone = caller_after(1s, turns, share);
  running->turn.pass();
  gone->wait_for_place();
  gone->left = true;
  wait_until([&] { return gone->went_on.load(); });
  EXPECT_TRUE(gone->stop.stop_requested());
  EXPECT_EQ(turns.waiting(), 0U);
  running->turn.give();
  EXPECT_EQ(turns.idle(), 1);
}

/// The items wait for each other: they end only if a helper takes part.
TEST(Helpers, TakeIdlePlaces) {
  Turns turns(2);
  Helpers helpers(turns, 1);
  Turns::Share share;
  std::stop_source stop;
  Turns::OfCall turn(turns, share, stop, [] { return false; });
  Helpers::OfCall crew(helpers, turn);
  struct Meeting {
    std::atomic<int> inside = 0;
    std::atomic<bool> met = false;
  } meeting;
  // The helper waits 100 µs for the work, and a leader may be put aside for longer before it
  // begins.
  while (!meeting.met)
    crew.run(
        2, 2e9,
        [](void* context, std::size_t) {
          auto& [inside, met] = *static_cast<Meeting*>(context);
          ++inside;
          for (int k = 0; k < 1000 && !met; ++k) {
            if (inside == 2) met = true;
            std::this_thread::yield();
          }
          --inside;
        },
        &meeting);
}

}  // namespace
}  // namespace stiefel::server
