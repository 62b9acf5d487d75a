#include "engine/frames/body/taylor_stiefel.h"

namespace stiefel {

template class TaylorStiefel<long double>;
template class TaylorMotion<TaylorStiefel<long double>>;

}  // namespace stiefel
