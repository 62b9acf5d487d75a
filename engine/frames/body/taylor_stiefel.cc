#include "engine/frames/body/taylor_stiefel.h"

namespace stiefel {

template class TaylorStiefel<long double>;
template class TaylorMotion<TaylorStiefel<long double>>;
template class TaylorStiefel<Quad>;
template class TaylorMotion<TaylorStiefel<Quad>>;

}  // namespace stiefel
