#include "engine/linalg/fixed_point.h"

namespace stiefel {

template class FixedPoint<double>;

}  // namespace stiefel
