#include "engine/linalg/lie/exponential.h"

namespace stiefel {

template class SkewExponential<double>;
template class SkewExponential<long double>;

}  // namespace stiefel
