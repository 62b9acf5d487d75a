#pragma once

namespace stiefel {

/// The instruction sets that kernels are compiled for. A kernel of one is a template over it in a
/// translation unit of its own, compiled for it, so that to the linker they are different symbols.
/// All give the same bits: sums do not depend on the lanes, and nothing is fused but what gives the
/// same unfused.
enum class Isa { baseline, avx2, avx512 };

/// The widest that this build has and this machine runs.
Isa widest_isa();

}  // namespace stiefel
