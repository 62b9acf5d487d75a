#include "engine/rigid_body/rigid_body_data.h"

#include "engine/rigid_body/rigid_body_invariants.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

SystemInfo rigid_body_family() {
  SystemInfo info{};
  info.blocks = {
      {"Q", "N x N", false, "frame, orthogonal, body to space; absent in a momentum-only scene"},
      {"M", "N x N", true, "body momentum, skew"},
  };
  info.fields = {
      {"Q", "N x N", "frame, orthogonal"},
      {"M", "N x N", "body momentum, skew"},
      {"Omega", "N x N",
       "body angular velocity: Omega_ij = M_ij / (lambda_i + lambda_j) in principal axes"},
      {"quaternion", "1 x 4", "N = 3, det Q = 1: w, x, y, z, body to space; sign continuous"},
      {"angular_velocity", "1 x 3", "N = 3: the vector of Omega"},
  };
  info.invariants = rigid_body_invariant_infos();
  info.invariants.push_back({family::orthogonality, "Q Q^T = I", ""});
  return info;
}

}  // namespace stiefel
