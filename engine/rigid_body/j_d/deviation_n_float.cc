#include "engine/rigid_body/j_d/deviation_n.h"

namespace stiefel {

template class DeviationSweeps<float>;
template class DeviationN<float>;

}  // namespace stiefel
