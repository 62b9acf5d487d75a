#include "engine/linalg/matrix_equations/constraint_riccati.h"

namespace stiefel {

template class ConstraintRiccati<double>;

}  // namespace stiefel
