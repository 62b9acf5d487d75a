#include "engine/simulation/packed_bodies.h"

#include <algorithm>
#include <cmath>

#include "engine/linalg/principal_moments_3.h"
#include "engine/linalg/so_4.h"
#include "engine/maps/preprocessed_moser_veselov.h"
#include "engine/methods/symmetric_stages.h"

namespace stiefel {
namespace {

constexpr Arithmetic either = Arithmetic::plain;  // what a body is made of is the same in both

/// Whether h m/I, or what is given as such, and its products are 0 or far from the ends of the
/// range: there a fused operation and its replacement give the same bits.
bool stays_normal(double x) { return x == 0 || (std::abs(x) > 0x1p-200 && std::abs(x) < 0x1p200); }

double step_of_map(const Scene& scene) { return scene.step() / scene.substeps(); }

/// The modified body in three dimensions is a single stage.
DiscreteInertia3<double> modified_inertia(const Scene& scene) {
  const ModifiedJDInverse3<double, false, either> inverse(scene.inertia(), step_of_map(scene),
                                                          scene.order());
  return inverse.J(vee(scene.M()));
}

/// Adds the body's stages, each to those of the other bodies.
template <class Pairs, class Inertia>
void add_stages(const Scene& scene, BodiesSideBySide::Stages<Inertia>& out) {
  const auto gamma = symmetric_stages<double>(std::max(scene.order(), 2));
  out.resize(gamma.size());
  for (std::size_t s = 0; s < gamma.size(); ++s)
    out[s].emplace_back(Pairs(scene.inertia()), gamma[s] * step_of_map(scene));
}

}  // namespace

PackedBodies::~PackedBodies() = default;

BodiesSideBySide side_by_side(std::span<const Scene> bodies, int lanes) {
  const Scene& first = bodies.front();
  BodiesSideBySide out{first.dimension(),
                       first.has_frame(),
                       first.arithmetic(),
                       first.substeps(),
                       step_of_map(first),
                       {},
                       {},
                       {}};
  for (std::size_t k = 0; k < static_cast<std::size_t>(lanes); ++k) {
    const Scene& body = bodies[std::min(k, bodies.size() - 1)];
    if (first.method() == "rk4") {
      out.lambda.emplace_back(body.inertia());
    } else if (first.method() == "preprocessed_variational") {
      out.stages_3.resize(1);
      out.stages_3[0].push_back(modified_inertia(body));
    } else if (first.dimension() == 3) {
      add_stages<PrincipalMoments3<long double>>(body, out.stages_3);
    } else {
      add_stages<PairSums4<long double>>(body, out.stages_4);
    }
  }
  return out;
}

int body_lanes() { return vector_width(widest_isa()); }

bool can_be_packed(const Scene& scene) {
  const bool rigid_body = scene.system() == "rigid_body" &&
                          (scene.method() == "rk4" || scene.method() == "variational" ||
                           scene.method() == "preprocessed_variational");
  const int N = scene.dimension();
  if (N < 3 || N > 4 || scene.in_float() || !(rigid_body || scene.system() == "moser_veselov"))
    return false;
  const double h = step_of_map(scene);
  for (int j = 0; j < N; ++j)
    for (int i = 0; i < j; ++i) {
      const double I = scene.inertia()(i) + scene.inertia()(j), m = scene.M()(i, j);
      if (!stays_normal(I) || !stays_normal(h * m / I) || !stays_normal(m)) return false;
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
