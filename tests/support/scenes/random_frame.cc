#include "tests/support/scenes/random_frame.h"

namespace stiefel::testing {

template struct RandomFrame<float>;
template struct RandomFrame<double>;
template struct RandomFrame<Quad>;

}  // namespace stiefel::testing
