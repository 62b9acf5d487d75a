#include "engine/linalg/iteration/fixed_point.h"

namespace stiefel {

template class FixedPoint<double>;

}  // namespace stiefel
