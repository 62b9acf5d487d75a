#pragma once

#include <algorithm>
#include <span>
#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <thread>
#else
#include <execution>
#endif

#include "stiefel/simulation.h"

namespace stiefel {

/// Work that takes less time is not divided.
inline constexpr double least_divided_nanoseconds = 1e5;

/// Calls `work` with each element, on all cores.
template <class Element, class Work>
void for_each_on_all_cores(std::span<Element> elements, const Work& work) {
#ifdef __SANITIZE_THREAD__
  // TBB is not built for the thread sanitizer, which would take its queues for data races.
  std::atomic<std::size_t> next = 0;
  const auto go = [&] {
    for (std::size_t i = next++; i < elements.size(); i = next++) work(elements[i]);
  };
  const std::jthread second(go), third(go);
  go();
#else
  std::for_each(std::execution::par, elements.begin(), elements.end(), work);
#endif
}

/// Calls `work` with each element, on several threads if all calls together take at least
/// `least_divided_nanoseconds`: on those of this thread's crew, without one on all cores.
/// `nanoseconds` is an estimate for all calls together.
template <class Element, class Work>
void for_each_in_parallel(std::span<Element> elements, double nanoseconds, const Work& work) {
  if (elements.size() < 2 || nanoseconds < least_divided_nanoseconds) {
    std::ranges::for_each(elements, work);
  } else if (Crew* crew = CrewOfThisThread::find()) {
    struct Context {
      std::span<Element> elements;
      const Work& work;
    } context{elements, work};
    crew->run(
        elements.size(), nanoseconds,
        [](void* all, std::size_t index) {
          auto& [them, each] = *static_cast<Context*>(all);
          each(them[index]);
        },
        &context);
  } else {
    for_each_on_all_cores(elements, work);
  }
}

}  // namespace stiefel
