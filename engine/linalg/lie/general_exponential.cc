#include "engine/linalg/lie/general_exponential.h"

namespace stiefel {

template class GeneralExponential<double>;
template class GeneralExponential<long double>;

}  // namespace stiefel
