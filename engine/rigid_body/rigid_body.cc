#include "engine/methods/preprocessed_variational.h"
#include "engine/methods/rk4.h"
#include "engine/methods/variational.h"
#include "engine/rigid_body/coordinates/body_by_method.h"
#include "engine/rigid_body/coordinates/exact_body.h"
#include "engine/catalogue/forms.h"
#include "engine/catalogue/methods/recommended.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_body_scene.h"
#include "engine/catalogue/methods/motion_rates.h"
#include "engine/catalogue/motions/motion_starts.h"
#include "engine/catalogue/representations/representations.h"
#include "engine/catalogue/system_entry.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make(const Scene& scene) {
  return is_exact_body(scene) ? exact_body(scene) : make_body_simulation(scene);
}

/// Returns the methods that move rigid bodies.
std::vector<MethodOnSystem> methods_on_bodies(const SystemInfo& info) {
  std::vector<MethodOnSystem> all;
  for (const BodyByMethod& body : bodies_by_methods()) all.push_back(body.declared(info));
  return all;
}

bool in_4d(const Scene& scene) { return scene.dimension() == 4; }
bool in_4d_without_frame(const Scene& scene) { return in_4d(scene) && !scene.has_frame(); }
bool away_from_separatrix(const Scene& scene) {
  return scene.dimension() == 3 && separatrix_parameter(scene) >= next_to_separatrix;
}

constexpr std::array recommendations = {
    Recommendation{.where = "ensembles, N = 3, no member next to the separatrix",
                   .takes = away_from_separatrix,
                   .members_only = true,
                   .method = PreprocessedVariational::traits.name,
                   .order = 14,
                   .largest_h_omega = 0.3},
    closed_form_of_body,
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
  info.file = "engine/rigid_body/body/rigid_body.h";
  info.methods = methods_on_bodies(info);
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
