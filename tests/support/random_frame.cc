#include "tests/support/random_frame.h"

namespace stiefel::testing {

template struct RandomFrame<double>;

}  // namespace stiefel::testing
