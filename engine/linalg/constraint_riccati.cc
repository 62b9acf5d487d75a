#include "engine/linalg/constraint_riccati.h"

namespace stiefel {

template class ConstraintRiccati<double>;

}  // namespace stiefel
