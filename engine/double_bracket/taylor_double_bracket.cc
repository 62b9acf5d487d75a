#include "engine/double_bracket/taylor_double_bracket.h"

namespace stiefel {

template class TaylorDoubleBracket<long double>;
template class TaylorMotion<TaylorDoubleBracket<long double>>;

}  // namespace stiefel
