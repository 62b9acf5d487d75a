#pragma once

namespace stiefel {

/// The instruction sets that kernels are compiled for. A kernel is a template over the instruction
/// set, in a translation unit compiled for it, so the linker sees different symbols. All give the
/// same bits: no sum depends on the number of lanes, and an operation is fused only where the
/// unfused result is the same.
enum class Isa { baseline, avx2, avx512 };

/// The widest instruction set that this build contains and this machine supports.
Isa widest_isa();

}  // namespace stiefel
