#include "engine/linalg/lie/skew_flow.h"

namespace stiefel {

template class SkewFlow<double>;
template class SkewFlow<long double>;

}  // namespace stiefel
