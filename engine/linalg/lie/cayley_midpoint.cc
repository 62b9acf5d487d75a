#include "engine/linalg/lie/cayley_midpoint.h"

namespace stiefel {

template class CayleyMidpoint<SoN<double>>;

}  // namespace stiefel
