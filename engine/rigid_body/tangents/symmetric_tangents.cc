#include "engine/laws/tangent_spaces.h"
#include "engine/linalg/lie/dual_skew_flow.h"
#include "engine/rigid_body/j_d/dual_j_d.h"
#include "engine/rigid_body/maps/right_rigid_body_maps.h"
#include "engine/rigid_body/maps/symmetric_rigid_body_maps.h"
#include "engine/rigid_body/moser_veselov/moser_veselov_pair.h"
#include "engine/rigid_body/symmetric/dual_psi.h"
#include "engine/rigid_body/symmetric/symmetric_invariants.h"
#include "engine/stepping/tangent_map_of.h"

namespace stiefel {
namespace {

using Made = std::unique_ptr<TangentMap>;
using Dense = Eigen::MatrixXd;

Tangent epsilon(const Scene& scene) { return scene.epsilon(); }
Matrix<Tangent> A(const Scene& scene) {
  return constant_A<double>(scene.Q(), scene.block("P")).cast<Tangent>();
}

/// (Qη, Pζ), η and ζ skew.
TangentSpace pairs(const Scene&) {
  return {TangentSpace::Coordinates::orthonormal,
          [](const Dense& x, const Dense& G) { return PairsOfRotations<double>().tangent(x, G); }};
}

}  // namespace

Tangents right_rigid_body_tangents() {
  return {[](const Scene&) {
            return TangentSpace{TangentSpace::Coordinates::right_body, {}};
          },
          [](const Scene& scene, const TangentParameters& at) {
            return make_tangent(scene, RightRigidBody<Tangent>(at.lambda), at.h);
          }};
}

Tangents symmetric_rigid_body_tangents() {
  return {pairs, [](const Scene& scene, const TangentParameters& at) {
            return make_tangent(scene, SymmetricRigidBody<Tangent>(at.lambda, epsilon(scene)),
                                at.h);
          }};
}

Tangents right_symmetric_rigid_body_tangents() {
  return {pairs, [](const Scene& scene, const TangentParameters& at) {
            return make_tangent(scene, RightSymmetricRigidBody<Tangent>(at.lambda, epsilon(scene)),
                                at.h);
          }};
}

/// A = PQᵀ is a constant of the scene, and only Q moves.
Tangents reduced_rigid_body_tangents() {
  return {[](const Scene&) {
            return TangentSpace{
                TangentSpace::Coordinates::orthonormal,
                [](const Dense& x, const Dense& G) { return tangent_to_frames<double>(x, G); }};
          },
          [](const Scene& scene, const TangentParameters& at) {
            return make_tangent(
                scene, ReducedRigidBody<Tangent>(at.lambda, A(scene), epsilon(scene)), at.h);
          }};
}

/// QᵀB skew: the tangent space of V(N, N) with Λ = I.
Tangents mclachlan_scovel_tangents() {
  return {[](const Scene& scene) {
            const CotangentOfFrames<double> space{Eigen::VectorXd::Ones(scene.dimension())};
            return TangentSpace{
                TangentSpace::Coordinates::orthonormal,
                [space](const Dense& x, const Dense& G) { return space.tangent(x, G); }};
          },
          [](const Scene& scene, const TangentParameters& at) {
            return make_tangent(scene, McLachlanScovel<Tangent>(at.lambda), at.h);
          }};
}

Tangents symmetric_moser_veselov_tangents() {
  return {pairs, [](const Scene& scene, const TangentParameters& at) {
            return make_tangent_by<Variational>(
                scene, SymmetricRigidBody<Tangent>(at.lambda, epsilon(scene)), at.h);
          }};
}

Tangents moser_veselov_pair_tangents() {
  return {pairs, [](const Scene& scene, const TangentParameters& at) -> Made {
            return std::make_unique<TangentMapOf<MoserVeselovPair<Tangent>>>(
                [&] { return MoserVeselovPair<Tangent>(at.lambda, at.h); }, scene.substeps());
          }};
}

}  // namespace stiefel
