// Compiled with AVX2 and FMA. What stands in here may be named by nobody else, lest the linker take
// it for all machines: everything that is not inlined is a template over Isa::avx2.
#include "engine/simulation/packed_bodies_on.h"

namespace stiefel {

template std::unique_ptr<PackedBodies> pack_bodies_on<Isa::avx2, 4>(const BodiesSideBySide&);

}  // namespace stiefel
