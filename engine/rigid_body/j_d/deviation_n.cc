#include "engine/rigid_body/j_d/deviation_n.h"

namespace stiefel {

template class DeviationSweeps<double>;
template class DeviationN<double>;

}  // namespace stiefel
