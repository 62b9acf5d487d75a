#include "engine/simulation/catalogue/families/rigid_body_observables.h"

namespace stiefel {

RigidBodyFields::RigidBodyFields(const Scene& scene) {
  const int N = scene.dimension();
  const auto offer = [this](const char* name, RigidBodyField kind, int rows, int cols) {
    fields.push_back({name, rows, cols});
    kinds.push_back(kind);
  };
  if (scene.has_frame()) offer("Q", RigidBodyField::Q, N, N);
  offer("M", RigidBodyField::M, N, N);
  block_count = fields.size();
  offer("Omega", RigidBodyField::Omega, N, N);
  if (N == 3 && scene.has_frame() && scene.determinant() == 1)
    offer("quaternion", RigidBodyField::quaternion, 1, 4);
  if (N == 3) offer("angular_velocity", RigidBodyField::angular_velocity, 1, 3);
  if (scene.method().empty()) map_step = scene.step();
}

}  // namespace stiefel
