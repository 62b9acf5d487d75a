#include "engine/linalg/lie/exponential.h"

#include "engine/linalg/lie/cayley_midpoint.h"
#include "engine/linalg/lie/general_exponential.h"
#include "engine/linalg/lie/skew_flow.h"

namespace stiefel {

template class SkewExponential<double>;
template class SkewExponential<long double>;
template class GeneralExponential<double>;
template class GeneralExponential<long double>;
template class SkewFlow<double>;
template class SkewFlow<long double>;
template class CayleyMidpoint<SoN<double>>;

}  // namespace stiefel
