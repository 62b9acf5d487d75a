#include "tests/support/linalg/quadruple.h"

template class Eigen::PartialPivLU<stiefel::Matrix<stiefel::Quad>>;

namespace stiefel {

template class CayleyN<Quad>;

}  // namespace stiefel
