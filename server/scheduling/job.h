#pragma once

#include <cstdint>

namespace stiefel::server {

/// The length of a job's slices, which decides which workers may run it.
enum class JobKind : std::uint8_t {
  brief,     ///< as short as `brief_slice_nanoseconds`
  sliced,    ///< about `slice_nanoseconds`
  unsliced,  ///< longer, up to seconds: a search, or one step of a large body
};

/// The nominal speed of one thread, which converts between its processor time and work.
inline constexpr double instructions_a_nanosecond = 5;
inline constexpr double instructions_a_second = 1e9 * instructions_a_nanosecond;

/// The most predicted work, in instructions, of a short call, which goes before all others: about
/// one slice. Up to `medium_work`, about ten slices, it goes before longer ones.
inline constexpr double short_work = 1e7, medium_work = 10 * short_work;

/// Returns the price, in instructions, of work that cannot be predicted, for a job of that kind:
/// about one slice, or ten seconds for work without slices.
inline double price_cap(JobKind kind) { return kind == JobKind::unsliced ? 5e10 : short_work; }

}  // namespace stiefel::server
