#include "engine/methods/gauss4.h"

namespace stiefel {

template class Gauss4::Stages<MatrixSystem<double>, Arithmetic::compensated>;
template class Gauss4::Stages<MatrixSystem<double>, Arithmetic::plain>;

}  // namespace stiefel
