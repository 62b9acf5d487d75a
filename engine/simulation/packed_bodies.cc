#include "engine/simulation/packed_bodies.h"

#include <algorithm>
#include <cmath>

#include "engine/linalg/j_d_3.h"
#include "engine/maps/preprocessed_moser_veselov.h"
#include "engine/methods/symmetric_stages.h"
#include "engine/simulation/packed_bodies_on.h"

namespace stiefel {
namespace {

constexpr Arithmetic either = Arithmetic::plain;  // what a body is made of is the same in both

/// Whether h m/I, or what is given as such, and its products are 0 or far from the ends of the
/// range: there a fused operation and its replacement give the same bits.
bool stays_normal(double x) { return x == 0 || (std::abs(x) > 0x1p-200 && std::abs(x) < 0x1p200); }

/// Of one body, by stages.
std::vector<DiscreteInertia3<double>> stages_of(const Scene& scene) {
  const double h = scene.step() / scene.substeps();
  if (scene.method() == "preprocessed_variational") {
    const ModifiedJDInverse3<double, false, either> inverse(scene.inertia(), h, scene.order());
    return {inverse.J(vee(scene.M()))};
  }
  std::vector<DiscreteInertia3<double>> stages;
  const PrincipalMoments3<long double> moments(scene.inertia());
  for (const double gamma : symmetric_stages<double>(std::max(scene.order(), 2)))
    stages.emplace_back(moments, gamma * h);
  return stages;
}

}  // namespace

PackedBodies::~PackedBodies() = default;

BodiesSideBySide side_by_side(std::span<const Scene> bodies, int lanes) {
  const Scene& first = bodies.front();
  BodiesSideBySide out{first.has_frame(),
                       first.arithmetic(),
                       first.substeps(),
                       first.step() / first.substeps(),
                       {},
                       {}};
  for (std::size_t k = 0; k < static_cast<std::size_t>(lanes); ++k) {
    const Scene& body = bodies[std::min(k, bodies.size() - 1)];
    if (first.method() == "rk4") {
      out.lambda.emplace_back(body.inertia());
      continue;
    }
    const auto stages = stages_of(body);
    out.stages.resize(stages.size());
    for (std::size_t s = 0; s < stages.size(); ++s) out.stages[s].push_back(stages[s]);
  }
  return out;
}

int body_lanes() { return vector_width(widest_isa()); }

bool can_be_packed(const Scene& scene) {
  const bool rigid_body = scene.system() == "rigid_body" &&
                          (scene.method() == "rk4" || scene.method() == "variational" ||
                           scene.method() == "preprocessed_variational");
  if (scene.dimension() != 3 || !(rigid_body || scene.system() == "moser_veselov")) return false;
  const Eigen::Vector3d lambda = scene.inertia(), m = vee(scene.M());
  const double h = scene.step() / scene.substeps();
  for (int i = 0; i < 3; ++i) {
    const double I = lambda((i + 1) % 3) + lambda((i + 2) % 3);
    if (!stays_normal(I) || !stays_normal(h * m(i) / I) || !stays_normal(m(i))) return false;
  }
  return stays_normal(h);
}

std::unique_ptr<PackedBodies> pack_bodies(std::span<const Scene> bodies) {
  const auto together = side_by_side(bodies, body_lanes());
#ifdef STIEFEL_X86_64
  if (widest_isa() == Isa::avx512) return pack_bodies_on<Isa::avx512>(together);
  if (widest_isa() == Isa::avx2) return pack_bodies_on<Isa::avx2>(together);
#endif
  return pack_bodies_on<Isa::baseline>(together);
}

}  // namespace stiefel
