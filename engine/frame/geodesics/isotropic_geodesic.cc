#include "engine/frame/geodesics/isotropic_geodesic.h"

namespace stiefel {

template class IsotropicGeodesic<double>;
template class IsotropicGeodesic<long double>;

}  // namespace stiefel
