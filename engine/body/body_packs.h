#pragma once

#include <vector>

#include "engine/body/j_d/discrete_inertia.h"
#include "engine/motion/packed_bodies.h"
#include "engine/numbers/isa.h"

namespace stiefel {

/// Bodies in three and four dimensions in packs. They take a scene where the processor has packs
/// (on x86-64 with AVX2), its method (MethodTraits::packing) allows it, N is 3 or 4, and products
/// of its numbers neither overflow nor become denormal; and the method `exact` for N = 3.
extern const Packs body_packs;

/// A body of one ensemble, for a pack.
struct PackedBody {
  Eigen::Vector4d lambda;                       ///< the first N
  Eigen::Vector3d m = Eigen::Vector3d::Zero();  ///< at step 0, for N = 3
};
PackedBody packed_body(const Scene& scene);

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
  /// For Packing::vector_field, lane by lane.
  std::vector<Eigen::Matrix<Scalar, 4, 1, Eigen::DontAlign>> lambda;
  /// For the discrete body: stage by stage, and in each stage lane by lane.
  template <class Inertia>
  using Stages = std::vector<std::vector<Inertia>>;
  Stages<DiscreteInertia3<Scalar>> stages_3;
  Stages<DiscreteInertia4<Scalar>> stages_4;
};

/// Packs at most `body_lanes` bodies of the ensemble of `like`. The lanes without a body repeat the
/// last one.
std::unique_ptr<PackedBodies> pack_bodies(const Scene& like, std::span<const PackedBody> bodies);
/// Returns the data of the bodies for pack_bodies_on; pack_bodies calls it.
template <class Scalar>
BodiesSideBySide<Scalar> side_by_side(const Scene& like, std::span<const PackedBody> bodies,
                                      int lanes);
extern template BodiesSideBySide<float> side_by_side(const Scene&, std::span<const PackedBody>,
                                                     int);
extern template BodiesSideBySide<double> side_by_side(const Scene&, std::span<const PackedBody>,
                                                      int);

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
