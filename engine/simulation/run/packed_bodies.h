#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/linalg/simd/isa.h"
#include "engine/moser_veselov/discrete_inertia.h"
#include "stiefel/scene.h"

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

/// Bodies that are stepped side by side in packs of Scalars, double or float. Two of the last three
/// members are empty.
template <class Scalar_>
struct BodiesSideBySide {
  using Scalar = Scalar_;

  int N;  ///< 3 or 4
  bool frame;
  Arithmetic arithmetic;
  int substeps;
  Scalar h;
  std::vector<Vector<Scalar>> lambda;  ///< for Packing::vector_field, lane by lane
  template <class Inertia>
  using Stages = std::vector<std::vector<Inertia>>;  ///< of the discrete body, by lanes
  Stages<DiscreteInertia3<Scalar>> stages_3;
  Stages<DiscreteInertia4<Scalar>> stages_4;
};

/// The lanes on this machine for bodies like this one.
int body_lanes(const Scene& scene);
/// Whether a scene goes together with others like it: a system (SystemEntry::packed) and a method
/// (MethodTraits::packing) that do, N = 3 or 4, numbers whose products stay normal.
bool can_be_packed(const Scene& scene);
/// At most `body_lanes` such bodies, of one ensemble; lanes that are left over repeat the last.
std::unique_ptr<PackedBodies> pack_bodies(std::span<const Scene> bodies);
/// The argument of the functions below, made by pack_bodies.
template <class Scalar>
BodiesSideBySide<Scalar> side_by_side(std::span<const Scene> bodies, int lanes);
extern template BodiesSideBySide<float> side_by_side(std::span<const Scene>, int);
extern template BodiesSideBySide<double> side_by_side(std::span<const Scene>, int);

/// Those compiled for `isa`, each from packed_bodies.cc.in: a file for each, because the compiler
/// inlines only so much in one.
template <Isa isa, int N, class Scalar>
std::unique_ptr<PackedBodies> pack_bodies_on(const BodiesSideBySide<Scalar>& bodies);
template <Isa isa, class Scalar>
std::unique_ptr<PackedBodies> pack_bodies_on(const BodiesSideBySide<Scalar>& bodies) {
  return bodies.N == 3 ? pack_bodies_on<isa, 3>(bodies) : pack_bodies_on<isa, 4>(bodies);
}

}  // namespace stiefel
