#pragma once

#include <algorithm>
#include <execution>
#include <vector>

#include "engine/simulation/run/crew.h"

namespace stiefel {

/// Work that takes less time is not divided.
inline constexpr double least_divided_nanoseconds = 1e5;

/// Calls `work` with each element, on several threads if all calls together take at least
/// `least_divided_nanoseconds`. `nanoseconds` is an estimate for all calls together.
template <class Element, class Work>
void for_each_in_parallel(std::vector<Element>& elements, double nanoseconds, const Work& work) {
  if (elements.size() < 2 || nanoseconds < least_divided_nanoseconds) {
    std::ranges::for_each(elements, work);
  } else if (Crew* crew = CrewOfThisThread::find()) {
    struct Context {
      std::vector<Element>& elements;
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
    std::for_each(std::execution::par, elements.begin(), elements.end(), work);
  }
}

}  // namespace stiefel
