#include "engine/linalg/lie/exponential_of.h"

#include "engine/linalg/lie/cayley_midpoint.h"
#include "engine/linalg/lie/skew_flow.h"

namespace stiefel {

template class Exponential<double>;
template class Exponential<long double>;
template class SkewFlow<double>;
template class SkewFlow<long double>;
template class CayleyMidpoint<SoN<double>>;

}  // namespace stiefel
