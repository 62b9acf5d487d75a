#pragma once

namespace stiefel {

/// The instruction sets for which kernels are compiled. A kernel is a template over the instruction
/// set, in a translation unit compiled for it, so that the linker sees different symbols. All
/// instruction sets give the same bits: no sum depends on the number of lanes, and an operation is
/// fused only where the unfused result is the same.
enum class Isa { baseline, avx2, avx512 };

/// Returns the widest instruction set that this build contains and this machine supports.
Isa widest_isa();

}  // namespace stiefel
