// Compiled with AVX-512. What stands in here may be named by nobody else, lest the linker take it
// for all machines: everything that is not inlined is a template over Isa::avx512.
#include "engine/simulation/packed_bodies_on.h"

namespace stiefel {

template std::unique_ptr<PackedBodies> pack_bodies_on<Isa::avx512, 3>(const BodiesSideBySide&);

}  // namespace stiefel
