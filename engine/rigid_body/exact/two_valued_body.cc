#include "engine/rigid_body/exact/two_valued_body.h"

namespace stiefel {

template class TwoValuedBody<double>;
template class TwoValuedBody<long double>;

}  // namespace stiefel
