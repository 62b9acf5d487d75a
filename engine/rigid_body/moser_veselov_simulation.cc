#include "engine/catalogue/system_entry.h"
#include "engine/rigid_body/coordinates/body_by_method.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {

Simulations moser_veselov_simulations() { return {make_body_simulation, keeps_all}; }

}  // namespace stiefel
