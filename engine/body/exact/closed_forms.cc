#include "engine/body/exact/turned_body.h"

namespace stiefel {

template class EulerTop<long double, false>;
template class EulerTop<long double, true>;
template class TwoValuedBody<double>;
template class TwoValuedBody<long double>;
template class BodyRotation<long double>;
template class TurnedBody<long double>;

}  // namespace stiefel
