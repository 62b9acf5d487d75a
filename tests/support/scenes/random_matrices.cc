#include "tests/support/scenes/random_matrices.h"

namespace stiefel::testing {

template class RandomMatrices<double>;
template class RandomMatrices<long double>;
template class RandomMatrices<Quad>;

}  // namespace stiefel::testing
