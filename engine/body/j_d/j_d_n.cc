#include "engine/body/j_d/j_d_n.h"

#include "engine/body/j_d/cayley_n.h"
#include "engine/body/j_d/deviation_n.h"
#include "engine/body/j_d/rotation_n.h"

namespace stiefel {

template class CayleyN<double>;
template class DeviationSweeps<double>;
template class DeviationN<double>;
template class RotationN<double>;
template class JDInverseN<double>;

}  // namespace stiefel
