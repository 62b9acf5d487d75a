#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <mutex>
#include <span>

#include "stiefel/crew.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Work of a call that takes less time is not divided, because threads may have to be woken for it.
inline constexpr double least_divided_nanoseconds = 1e5;

/// The order of the smallest matrices whose products and passes are divided.
inline constexpr Eigen::Index least_divided_order = 128;

/// Returns the crew that shares what this thread divides; null within an item of a crew.
Crew* crew_to_divide();

/// Calls `work` with 0 ... count - 1, on the threads of the crew.
template <class Work>
void share_out(Crew& crew, std::size_t count, double nanoseconds, const Work& work) {
  crew.run(
      count, nanoseconds,
      [](void* context, std::size_t index) { (*static_cast<const Work*>(context))(index); },
      const_cast<void*>(static_cast<const void*>(&work)));
}

/// Calls `work` with each element, on several threads if all calls together take at least
/// `least_divided_nanoseconds`. `nanoseconds` is an estimate for all calls together.
template <class Element, class Work>
void for_each_in_parallel(std::span<Element> elements, double nanoseconds, const Work& work) {
  Crew* crew =
      elements.size() < 2 || nanoseconds < least_divided_nanoseconds ? nullptr : crew_to_divide();
  if (crew)
    share_out(*crew, elements.size(), nanoseconds, [&](std::size_t i) { work(elements[i]); });
  else
    std::ranges::for_each(elements, work);
}

/// Calls work(begin, end) for consecutive ranges that together are 0 ... count, on the threads of
/// the crew, the last range first. Ranges begin at multiples of `unit` and are no shorter; how many
/// there are depends on the threads, so the result of `work` must not depend on the division.
/// `nanoseconds` is an estimate of the work on all. For parts of the work on matrices of at least
/// `least_divided_order`.
template <class Work>
void in_ranges(Eigen::Index count, Eigen::Index unit, double nanoseconds, const Work& work,
               Eigen::Index ranges_a_thread = 4) {
  constexpr double least_nanoseconds = 5e3;  // of a range
  const Eigen::Index units = count / unit;
  Crew* crew = units < 2 || nanoseconds < 2 * least_nanoseconds ? nullptr : crew_to_divide();
  const auto threads = crew ? static_cast<Eigen::Index>(crew->threads_at_hand()) : 1;
  if (threads < 2) return work(Eigen::Index{0}, count);
  const auto worth = static_cast<Eigen::Index>(std::min(nanoseconds / least_nanoseconds, 1e6));
  Eigen::Index ranges = std::min({worth, ranges_a_thread * threads, units});
  if (ranges > threads) ranges -= ranges % threads;
  const Eigen::Index size = (units + ranges - 1) / ranges * unit, last = (units * unit - 1) / size;
  share_out(*crew, static_cast<std::size_t>(last + 1), nanoseconds, [&](std::size_t index) {
    const auto i = last - static_cast<Eigen::Index>(index);
    work(i * size, i == last ? count : (i + 1) * size);
  });
}

/// Copies so many numbers, in ranges.
template <class From, class To>
[[gnu::noinline]] void copy_numbers(const From* from, Eigen::Index count, To* to) {
  constexpr Eigen::Index unit = 4096;
  in_ranges(count, unit, static_cast<double>(count) / 2, [&](Eigen::Index begin, Eigen::Index end) {
    std::copy(from + begin, from + end, to + begin);
  });
}

/// Calls work(begin, end) like `in_ranges` over the columns of a product with a large matrix, or of
/// a solution of equations with one: in fewer and wider ranges, because each reads the whole
/// matrix. Work that takes long begins with a stop point (stiefel/stop.h).
template <class Work>
void in_wide_ranges(Eigen::Index columns, double nanoseconds, const Work& work) {
  constexpr double least_nanoseconds = 2.5e5;
  constexpr Eigen::Index ranges_a_thread = 2;
  const Eigen::Index unit = columns < 512 ? 16 : 32;  // a range for each of 16 threads from 256 on
  if (nanoseconds < least_nanoseconds) return work(Eigen::Index{0}, columns);
  stop_point();
  in_ranges(columns, unit, nanoseconds, work, ranges_a_thread);
}

/// Calls work(begin, end) like `in_ranges` over the columns of a matrix of at least
/// `least_divided_order`, each of `of_column` nanoseconds; over those of a smaller one at once.
template <class Work>
void in_column_ranges(Eigen::Index columns, double of_column, const Work& work) {
  constexpr Eigen::Index tile = 16;
  if (columns < least_divided_order) return work(Eigen::Index{0}, columns);
  in_ranges(columns, tile, of_column * static_cast<double>(columns), work);
}

/// Returns the largest of what work(begin, end) returns for such ranges of columns, at least 0.
template <class Scalar, class Work>
Scalar largest_in_column_ranges(Eigen::Index columns, double of_column, const Work& work) {
  std::mutex mutex;
  Scalar largest = 0;
  in_column_ranges(columns, of_column, [&](Eigen::Index begin, Eigen::Index end) {
    const Scalar here = work(begin, end);
    const std::lock_guard lock(mutex);
    largest = std::max(largest, here);
  });
  return largest;
}

}  // namespace stiefel
