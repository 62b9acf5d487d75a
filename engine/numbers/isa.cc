#include "engine/numbers/isa.h"

namespace stiefel {

Isa widest_isa() {
#ifdef STIEFEL_X86_64
  static const Isa widest = [] {
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("fma"))
      return Isa::avx512;
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    return avx2 ? Isa::avx2 : Isa::baseline;
  }();
  return widest;
#else
  return Isa::baseline;
#endif
}

}  // namespace stiefel
