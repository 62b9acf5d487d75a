#include "tests/support/linalg/quadruple.h"

namespace stiefel {

template class CayleyN<Quad>;

}  // namespace stiefel
