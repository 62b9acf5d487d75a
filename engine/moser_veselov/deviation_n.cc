#include "engine/moser_veselov/deviation_n.h"

namespace stiefel {

template class DeviationSweeps<double>;
template class DeviationN<double>;

}  // namespace stiefel
