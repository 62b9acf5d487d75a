#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/numbers/isa.h"
#include "engine/rigid_body/j_d/discrete_inertia.h"
#include "stiefel/scene.h"

namespace stiefel {

/// As many bodies in three or four dimensions as a vector register has lanes, advanced together.
/// Each has the bits that it has alone, because lanes are independent and run the same source code.
/// A step that is not easy for some of them (an equation that converges slowly, a state that is not
/// finite) is left to their own Simulations.
class PackedBodies {
 public:
  /// Number of steps that all bodies took, and the lanes that took one step more.
  struct Progress {
    std::int64_t steps;
    unsigned further;
  };

  virtual ~PackedBodies();
  virtual int lanes() const = 0;
  /// Advances by up to `steps`, and stops before a step that is not easy for all bodies. `states`
  /// holds what Simulation::save gives for each body, one after another.
  virtual Progress advance(std::span<double> states, std::int64_t steps) = 0;
};

/// The data of bodies that advance side by side in packs of Scalars, double, or float for N = 3.
/// Two of the last three members are empty.
template <class Scalar_>
struct BodiesSideBySide {
  using Scalar = Scalar_;

  int N;  ///< 3 or 4
  bool frame;
  Arithmetic arithmetic;
  int substeps;
  Scalar h;
  std::vector<Vector<Scalar>> lambda;  ///< for Packing::vector_field, lane by lane
  /// For the discrete body: stage by stage, and in each stage lane by lane.
  template <class Inertia>
  using Stages = std::vector<std::vector<Inertia>>;
  Stages<DiscreteInertia3<Scalar>> stages_3;
  Stages<DiscreteInertia4<Scalar>> stages_4;
};

/// Returns the number of lanes on this machine for bodies like this one.
int body_lanes(const Scene& scene);
/// Whether a scene can advance together with others like it: the processor has packs (on x86-64
/// with AVX2), its system (SystemEntry::packed) and method (MethodTraits::packing) allow it, N is 3
/// or 4, and products of its numbers neither overflow nor become denormal.
bool can_be_packed(const Scene& scene);
/// Packs at most `body_lanes` bodies of one ensemble. The lanes without a body repeat the last one.
std::unique_ptr<PackedBodies> pack_bodies(std::span<const Scene> bodies);
/// Returns the data of the bodies for pack_bodies_on; pack_bodies calls it.
template <class Scalar>
BodiesSideBySide<Scalar> side_by_side(std::span<const Scene> bodies, int lanes);
extern template BodiesSideBySide<float> side_by_side(std::span<const Scene>, int);
extern template BodiesSideBySide<double> side_by_side(std::span<const Scene>, int);

/// Packs bodies with the code compiled for `isa`. packed_bodies.cc.in is compiled to a file for
/// each set of template arguments, because the compiler limits how much it inlines in one file.
template <Isa isa, int N, class Scalar>
std::unique_ptr<PackedBodies> pack_bodies_on(const BodiesSideBySide<Scalar>& bodies);
template <Isa isa, class Scalar>
std::unique_ptr<PackedBodies> pack_bodies_on(const BodiesSideBySide<Scalar>& bodies) {
  if constexpr (std::is_same_v<Scalar, double>)
    if (bodies.N == 4) return pack_bodies_on<isa, 4>(bodies);
  return pack_bodies_on<isa, 3>(bodies);
}

}  // namespace stiefel
