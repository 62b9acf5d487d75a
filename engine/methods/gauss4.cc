#include "engine/methods/gauss4.h"

namespace stiefel {

template class Gauss4::Stages<MatrixSystem<double>>;

}  // namespace stiefel
