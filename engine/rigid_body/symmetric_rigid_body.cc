#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/symmetric_data.h"

namespace stiefel {

SystemEntry symmetric_rigid_body_entry() {
  SystemEntry entry = symmetric_family();
  SystemInfo& info = entry.info;
  info.name = "symmetric_rigid_body";
  info.summary = "symmetric representation of the rigid body";
  info.equations = "Q' = Q Omega, P' = P Omega, M = (Q^T P - P^T Q) / epsilon";
  info.source = "[RB] (3.1), Prop. 3.13";
  info.file = "engine/rigid_body/symmetric/symmetric_rigid_body.h";
  entry.recommended = for_products;
  entry.dirac_bracket = true;
  return entry;
}

}  // namespace stiefel
