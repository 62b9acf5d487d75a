#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/linalg/discrete_inertia.h"
#include "engine/linalg/isa.h"
#include "engine/simulation/scene.h"

namespace stiefel {

/// As many bodies in three or four dimensions as a vector register has lanes, advanced together.
/// Each has the bits that it has alone, because lanes do not see each other and what is computed in
/// them is the same source. A step that is not easy for some of them (an equation that converges
/// slowly, a state that is not finite) is left to their own Simulations.
class PackedBodies {
 public:
  /// `steps` that all of them took, and the lanes that took one more.
  struct Progress {
    std::int64_t steps;
    unsigned further;
  };

  virtual ~PackedBodies();
  virtual int lanes() const = 0;
  /// Up to `steps`, and no further than a step that is not easy for all. `states` is what
  /// Simulation::save gives of each, one after another.
  virtual Progress advance(std::span<double> states, std::int64_t steps) = 0;
};

/// What bodies are made of that go together. Of the last three two are empty.
struct BodiesSideBySide {
  int N;  ///< 3 or 4
  bool frame;
  Arithmetic arithmetic;
  int substeps;
  double h;
  std::vector<Eigen::VectorXd> lambda;  ///< for rk4, lane by lane
  template <class Inertia>
  using Stages = std::vector<std::vector<Inertia>>;  ///< of the discrete body, by lanes
  Stages<DiscreteInertia3<double>> stages_3;
  Stages<DiscreteInertia4<double>> stages_4;
};

/// The lanes on this machine.
int body_lanes();
/// Whether a scene's method and size are among those that go together: rigid_body and moser_veselov
/// with N = 3 or 4; rk4, variational, preprocessed_variational; numbers whose products stay normal.
bool can_be_packed(const Scene& scene);
/// At most `body_lanes()` such bodies, of one ensemble; lanes that are left over repeat the last.
std::unique_ptr<PackedBodies> pack_bodies(std::span<const Scene> bodies);
/// What pack_bodies hands to one of the functions below.
BodiesSideBySide side_by_side(std::span<const Scene> bodies, int lanes);

/// Those compiled for `isa`, in packed_bodies_N_ISA.cc: a file each, because the compiler inlines
/// only so much in one.
template <Isa isa, int N>
std::unique_ptr<PackedBodies> pack_bodies_on(const BodiesSideBySide& bodies);
template <Isa isa>
std::unique_ptr<PackedBodies> pack_bodies_on(const BodiesSideBySide& bodies) {
  return bodies.N == 3 ? pack_bodies_on<isa, 3>(bodies) : pack_bodies_on<isa, 4>(bodies);
}

extern template std::unique_ptr<PackedBodies> pack_bodies_on<Isa::baseline, 3>(
    const BodiesSideBySide&);
extern template std::unique_ptr<PackedBodies> pack_bodies_on<Isa::baseline, 4>(
    const BodiesSideBySide&);
#ifdef STIEFEL_X86_64
extern template std::unique_ptr<PackedBodies> pack_bodies_on<Isa::avx2, 3>(const BodiesSideBySide&);
extern template std::unique_ptr<PackedBodies> pack_bodies_on<Isa::avx2, 4>(const BodiesSideBySide&);
extern template std::unique_ptr<PackedBodies> pack_bodies_on<Isa::avx512, 3>(
    const BodiesSideBySide&);
extern template std::unique_ptr<PackedBodies> pack_bodies_on<Isa::avx512, 4>(
    const BodiesSideBySide&);
#endif

}  // namespace stiefel
