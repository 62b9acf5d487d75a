#include "engine/linalg/general_exponential.h"

namespace stiefel {

template class GeneralExponential<double>;

}  // namespace stiefel
