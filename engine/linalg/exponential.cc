#include "engine/linalg/exponential.h"

namespace stiefel {

template class SkewExponential<double>;

}  // namespace stiefel
