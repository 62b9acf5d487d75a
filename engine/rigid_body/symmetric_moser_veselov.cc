#include "engine/rigid_body/symmetric_data.h"

namespace stiefel {

SystemEntry symmetric_moser_veselov_entry() {
  SystemEntry entry = symmetric_family();
  SystemInfo& info = entry.info;
  info.name = "symmetric_moser_veselov";
  info.summary = "symmetric representation of the discrete rigid body";
  info.equations = "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k U, P_{k+1} = P_k U";
  info.source = "[RB] (4.7)";
  info.file = "engine/rigid_body/moser_veselov/symmetric_moser_veselov.h";
  info.discrete = true;
  info.velocity = {};
  info.invariants.push_back(discrete_hamiltonian_info);
  entry.check = [](SceneDraft& draft) { check_symmetric(draft, false, draft.step()); };
  entry.dirac_bracket = true;
  return entry;
}

}  // namespace stiefel
