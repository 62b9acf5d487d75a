#include "engine/rigid_body/body/rigid_body.h"
#include "engine/catalogue/representation.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/tangents/rigid_tangents.h"

namespace stiefel {
namespace {

bool in_4d(const Scene& scene) { return scene.dimension() == 4; }
bool in_4d_without_frame(const Scene& scene) { return in_4d(scene) && !scene.has_frame(); }
bool away_from_separatrix(const Scene& scene) {
  return scene.dimension() == 3 && body_rates.separatrix(scene) >= next_to_separatrix;
}

constexpr std::array recommendations = {
    Recommendation{.where = "ensembles, N = 3, no member next to the separatrix",
                   .takes = away_from_separatrix,
                   .members_only = true,
                   .method = "preprocessed_variational",
                   .order = 14,
                   .largest_h_omega = 0.3},
    closed_form_of_body,
    Recommendation{.where = "N = 4, without Q",
                   .takes = in_4d_without_frame,
                   .method = "rk4",
                   .order = 4,
                   .largest_h_momentum_rate = 0.0034},
    Recommendation{.where = "N = 4",
                   .takes = in_4d,
                   .method = "variational",
                   .order = 8,
                   .largest_h_omega = 0.15},
    with_error_control(1e-12, 0.15)};

}  // namespace

const char* const representations::body_system = RigidBody<SoN<double>>::name;

SystemEntry rigid_body_entry() {
  SystemEntry entry = rigid_body_family();
  SystemInfo& info = entry.info;
  info.name = "rigid_body";
  info.summary = "free rigid body in N dimensions";
  info.equations = "Q' = Q Omega, M' = [M, Omega], M = Lambda Omega + Omega Lambda";
  info.source = "[RB] (2.2), (2.3)";
  info.file = "engine/rigid_body/body/rigid_body.h";
  entry.recommended = recommendations;
  entry.in_float = true;
  entry.tangents = &rigid_body_tangents;
  return entry;
}

}  // namespace stiefel
