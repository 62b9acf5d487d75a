#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/symmetric_data.h"

namespace stiefel {

SystemEntry right_symmetric_rigid_body_entry() {
  SystemEntry entry = symmetric_family(Side::right);
  SystemInfo& info = entry.info;
  info.name = "right_symmetric_rigid_body";
  info.summary = "symmetric representation of the rigid body, right-invariant";
  info.equations = "Q' = Omega Q, P' = Omega P, M = (P Q^T - Q P^T) / epsilon";
  info.source = "[RB] Prop. 3.4";
  info.file = "engine/rigid_body/right_symmetric_rigid_body.cc";
  as_view_of_pair(entry);
  return entry;
}

Simulations right_symmetric_rigid_body_simulations() { return rigid_body_simulations(); }

}  // namespace stiefel
