#pragma once

namespace stiefel {

/// How a method treats an invariant of the exact motion. exact: keeps it to rounding for every
/// step size. bounded: the error oscillates and does not grow. drifts: the error grows with time.
enum class Conservation { exact, bounded, drifts };

}  // namespace stiefel
