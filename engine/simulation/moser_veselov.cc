#include "engine/maps/moser_veselov.h"

#include "engine/simulation/rigid_body_data.h"
#include "engine/simulation/simulation_of.h"
#include "engine/simulation/system_entry.h"

namespace stiefel {
namespace {

template <class Space>
std::unique_ptr<Simulation> make_in(const Scene& scene) {
  using Map = MoserVeselov<Space, Arithmetic::compensated>;
  using Readout = RigidBodyReadout<Space>;
  const double N = scene.dimension();
  const double cost = N == 3 ? 300 : 1000 + 50 * N * N + 5 * N * N * N;
  return std::make_unique<SimulationOf<Map, Readout>>(scene, Map(scene.inertia(), scene.step()),
                                                      Readout(scene), cost);
}

std::unique_ptr<Simulation> make(const Scene& scene) {
  if (scene.dimension() != 3) return make_in<SoN<double>>(scene);
  if (scene.has_frame()) return make_in<So3<double, true>>(scene);
  return make_in<So3<double, false>>(scene);
}

}  // namespace

SystemEntry moser_veselov_entry() {
  SystemInfo info = rigid_body_family();
  info.name = "moser_veselov";
  info.summary = "discrete rigid body of Moser and Veselov, its own step as the time";
  info.equations = "U Lambda - Lambda U^T = h M, Q_{k+1} = Q_k U, M_{k+1} = U^T M_k U";
  info.source = "[RB] (4.5)";
  info.file = "engine/maps/moser_veselov.h";
  info.discrete = true;
  info.methods = {{"", preservations([](auto) { return Kept::exact; })}};
  return {info, make};
}

}  // namespace stiefel
