#include "engine/systems/rigid_body.h"

#include "engine/simulation/catalogue/coordinates/exact_body.h"
#include "engine/simulation/catalogue/coordinates/in_float.h"
#include "engine/simulation/catalogue/coordinates/rigid_body_4d.h"
#include "engine/simulation/catalogue/families/forms.h"
#include "engine/simulation/catalogue/families/recommended.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/families/rigid_body_observables.h"
#include "engine/simulation/catalogue/families/rigid_body_scene.h"
#include "engine/simulation/catalogue/motions/motion_starts.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/catalogue/system_entry.h"
#include "engine/simulation/stepping/simulate.h"

namespace stiefel {
namespace {

template <class Space>
std::unique_ptr<Simulation> make_in(const Scene& scene) {
  return simulate(scene, RigidBody<Space>(scene.inertia()), RigidBodyObservables<Space>(scene),
                  rigid_body_cost(scene.dimension()));
}

std::unique_ptr<Simulation> make(const Scene& scene) {
  if (is_rigid_body_4d(scene)) return rigid_body_4d(scene);
  if (scene.in_float()) return rigid_body_in_float(scene);
  if (is_exact_body(scene)) return exact_body(scene);
  if (scene.dimension() != 3) return make_in<SoN<double>>(scene);
  if (scene.has_frame()) return make_in<So3<double, true>>(scene);
  return make_in<So3<double, false>>(scene);
}

bool in_3d(const Scene& scene) { return scene.dimension() == 3; }
bool in_4d(const Scene& scene) { return scene.dimension() == 4; }
bool in_4d_without_frame(const Scene& scene) { return in_4d(scene) && !scene.has_frame(); }
bool stands_still(const Scene& scene) { return turns_evenly(scene) && !scene.has_frame(); }
bool of_two_values(const Scene& scene) { return TwoValuedBody<long double>::has(scene.inertia()); }

constexpr std::array recommendations = {
    Recommendation{.where = "N = 3",
                   .takes = in_3d,
                   .method = PreprocessedVariational::traits.name,
                   .order = 14,
                   .largest_h_omega = 0.3},
    Recommendation{.where = "without Q, N = 2 or Lambda a multiple of the identity",
                   .takes = stands_still,
                   .method = Variational::traits.name,
                   .order = 2},
    Recommendation{.where = "Lambda of at most two values",
                   .takes = of_two_values,
                   .method = Exact::traits.name,
                   .arithmetic = "compensated"},
    Recommendation{.where = "N = 4, without Q",
                   .takes = in_4d_without_frame,
                   .method = Rk4::traits.name,
                   .order = 4,
                   .largest_h_momentum_rate = 0.0034},
    Recommendation{.where = "N = 4",
                   .takes = in_4d,
                   .method = Variational::traits.name,
                   .order = 8,
                   .largest_h_omega = 0.15},
    with_error_control(1e-12, 0.15)};

}  // namespace

SystemEntry rigid_body_entry() {
  SystemInfo info = rigid_body_family();
  info.name = "rigid_body";
  info.summary = "free rigid body in N dimensions";
  info.equations = "Q' = Q Omega, M' = [M, Omega], M = Lambda Omega + Omega Lambda";
  info.source = "[RB] (2.2), (2.3)";
  info.file = "engine/systems/rigid_body.h";
  info.methods = methods_on<RigidBody<SoN<double>>, RigidBody<So3<double, true>>>(info);
  offer_in_float(info);
  return {.info = info,
          .check = check_rigid_body_or_engineers,
          .make = make,
          .recommended = recommendations,
          .two_forms = {&two_form::of_bodies},
          .representation = &representation::body,
          .motion = &motion_start::body,
          .rate = Rate::angular_speed,
          .packed = true};
}

}  // namespace stiefel
