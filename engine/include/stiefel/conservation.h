#pragma once

namespace stiefel {

/// How a method keeps an invariant of the exact motion: to rounding whatever the step; with an
/// error that oscillates but does not grow; with an error that grows with time.
enum class Conservation { exact, bounded, drifts };

}  // namespace stiefel
