#include "engine/linalg/isa.h"

namespace stiefel {

Isa widest_isa() {
#ifdef STIEFEL_X86_64
  static const bool avx2 = __builtin_cpu_supports("avx2") != 0;
  if (avx2) return Isa::avx2;
#endif
  return Isa::baseline;
}

}  // namespace stiefel
