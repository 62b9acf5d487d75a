#include "engine/simulation/packed_bodies_on.h"

namespace stiefel {

template std::unique_ptr<PackedBodies> pack_bodies_on<Isa::baseline, 3>(const BodiesSideBySide&);

}  // namespace stiefel
