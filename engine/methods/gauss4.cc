#include "engine/methods/gauss4.h"

namespace stiefel {

template class ImplicitMap<Gauss4::Stages<MatrixSystem<double>>, MatrixSystem<double>>;
template class Gauss4::Stages<MatrixSystem<double>>;

}  // namespace stiefel
