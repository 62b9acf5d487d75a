#include "engine/dense/exponential_of.h"

#include "engine/dense/cayley_midpoint.h"
#include "engine/dense/skew_flow.h"

namespace stiefel {

template class Exponential<double>;
template class Exponential<long double>;
template class SkewFlow<double>;
template class SkewFlow<long double>;
template class CayleyMidpoint<SoN<double>>;

}  // namespace stiefel
