#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_body_invariants.h"
#include "engine/rigid_body/tangents/rigid_tangents.h"

namespace stiefel {

SystemEntry moser_veselov_entry() {
  SystemEntry entry = rigid_body_family();
  SystemInfo& info = entry.info;
  info.name = "moser_veselov";
  info.summary = "discrete rigid body of Moser and Veselov, its own step as the time";
  info.equations = "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k U, M_{k+1} = U^T M_k U";
  info.source = "[RB] (4.5)";
  info.file = "engine/rigid_body/moser_veselov/moser_veselov.h";
  info.discrete = true;
  info.velocity = {};
  info.invariants.push_back(discrete_hamiltonian_info);
  entry.continuous = "rigid_body";
  entry.tangents = &moser_veselov_tangents;
  return entry;
}

}  // namespace stiefel
