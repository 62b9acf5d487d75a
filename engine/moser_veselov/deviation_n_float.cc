#include "engine/moser_veselov/deviation_n.h"

namespace stiefel {

template class DeviationSweeps<float>;
template class DeviationN<float>;

}  // namespace stiefel
