#include "engine/body/body_packs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/body/exact_body.h"
#include "engine/body/preprocessed_moser_veselov.h"
#include "engine/dense/principal_moments_3.h"
#include "engine/dense/so_4.h"
#include "engine/methods/symmetric_stages.h"
#include "engine/motion/body_view.h"
#include "engine/motion/method_entry.h"

namespace stiefel {
namespace {

/// Whether h m/I, or a given number of that size, and its products are 0 or far from the ends of
/// the range, where a fused operation and its replacement give the same bits.
bool is_far_from_ends(double x, bool in_float) {
  const double far = in_float ? 0x1p19 : 0x1p200;
  return x == 0 || (std::abs(x) > 1 / far && std::abs(x) < far);
}

/// A processor with x86-64 but without AVX2 steps each body alone, which gives the same bits.
bool has_packs() {
#ifdef STIEFEL_X86_64
  return widest_isa() != Isa::baseline;
#else
  return true;
#endif
}

double step_of_map(const Scene& scene) { return scene.step() / scene.substeps(); }

/// Returns how the scene's method packs bodies. A discrete body has no method and is packed by its
/// stages.
Packing packing_of(const Scene& scene) {
  const MethodEntry* method = method_entry(scene.method());
  return method ? method->traits.packing : Packing::stages;
}

/// Returns the inertia for the single stage of a modified body in three dimensions.
template <class Scalar>
DiscreteInertia3<Scalar> modified_inertia(const Scene& scene, Scalar h) {
  const ModifiedJDInverse3<Scalar, false> inverse(rounded_to<Scalar>(scene.inertia()), h,
                                                  scene.order());
  return inverse.memory(rounded_to<Scalar>(vee(body_momentum(scene))));
}

/// Appends the stages of a body to those of the other bodies.
template <class Pairs, class Scalar, class Inertia>
void add_stages(const Scene& scene, Scalar h, std::vector<std::vector<Inertia>>& out) {
  const auto gamma = symmetric_stages<Scalar>(std::max(scene.order(), 2));
  const auto lambda = rounded_to<Scalar>(scene.inertia());
  out.resize(gamma.size());
  for (std::size_t s = 0; s < gamma.size(); ++s) out[s].emplace_back(Pairs(lambda), gamma[s] * h);
}

int lanes_of(const Scene& scene) {
  return scene.in_float() ? vector_width<float>(widest_isa()) : vector_width<double>(widest_isa());
}

/// Whether products of the numbers of a body with the step of `like` stay normal.
bool stays_normal(const Scene& like, const Eigen::Ref<const Eigen::VectorXd>& lambda,
                  const Eigen::Ref<const Eigen::MatrixXd>& M) {
  const auto is_normal = [&](double x) { return is_far_from_ends(x, like.in_float()); };
  const double h = step_of_map(like);
  for (int j = 0; j < lambda.size(); ++j)
    for (int i = 0; i < j; ++i) {
      const double I = lambda(i) + lambda(j), m = M(i, j);
      if (!is_normal(I) || !is_normal(h * m / I) || !is_normal(m)) return false;
    }
  return is_normal(h);
}

bool takes(const Scene& scene) {
  const int N = scene.dimension();
  if (is_exact_body(scene)) return has_packs();
  if (!has_packs() || N < 3 || N > 4 || packing_of(scene) == Packing::none) return false;
  return stays_normal(scene, scene.inertia(), body_momentum(scene));
}

bool takes_body(const Scene& like, const Body3& body) {
  return is_exact_body(like) || stays_normal(like, body.lambda, hat(body.m));
}

/// Bodies in three dimensions by the method `exact`. Those without a motion in theta functions are
/// left to their own Simulations.
class PackedClosedForms final : public PackedBodies {
 public:
  PackedClosedForms(std::span<const Scene> bodies, std::span<const double> start)
      : substeps_(bodies.front().substeps()) {
    times_.unit = bodies.front().step() / substeps_;
    const std::size_t each = start.size() / static_cast<std::size_t>(lanes());
    for (std::size_t lane = 0; lane * each < start.size(); ++lane)
      bodies_.push_back(top_in_time(bodies[std::min(lane, bodies.size() - 1)],
                                    start.subspan(lane * each, each - 1)));
  }

  int lanes() const override { return ThetaTop::lanes(); }

  Progress advance(std::span<double> states, std::int64_t steps) override {
    if (!std::exchange(ready_, true)) put_side_by_side();
    const std::size_t each = states.size() / bodies_.size();
    unsigned easy = 0;
    for (std::size_t lane = 0; lane < bodies_.size(); ++lane) {
      const double k = states[lane * each + each - 1] + static_cast<double>(steps) * substeps_;
      const auto& theta = bodies_[lane].theta();
      times_.high[lane] = k;
      times_.low[lane] = 0;
      const auto time = static_cast<double>(static_cast<long double>(k) * times_.unit);
      if (theta && std::abs(k) < largest && theta->takes(time)) easy |= 1u << lane;
    }
    if (easy == 0) return {0, 0};
    side_by_side_.at(times_, states_);
    for (std::size_t lane = 0; lane < bodies_.size(); ++lane) {
      if (!(easy >> lane & 1)) continue;
      TopInTime& body = bodies_[lane];
      const auto x = body.rounded(states_, static_cast<int>(lane));
      const auto to = states.subspan(lane * each, each);
      std::ranges::copy(x.tail(static_cast<Eigen::Index>(each) - 1), to.begin());
      to.back() = times_.high[lane];
    }
    if (easy == (1u << lanes()) - 1) return {steps, 0};
    return {0, easy};
  }

 private:
  static constexpr double largest = 0x1p53;  ///< numbers of steps below are exact

  /// Computes the constants of the motions, which takes longer than many states: at the first
  /// advance, for which an ensemble uses all cores.
  void put_side_by_side() {
    const auto some =
        std::ranges::find_if(bodies_, [](TopInTime& body) { return body.theta().has_value(); });
    for (int lane = 0; lane < lanes() && some != bodies_.end(); ++lane)
      side_by_side_.put(lane, bodies_[lane].theta() ? *bodies_[lane].theta() : *some->theta());
  }

  std::vector<TopInTime> bodies_;
  ThetaTops side_by_side_;
  ThetaTop::Times times_{};
  ThetaTop::Lanes states_;
  int substeps_;
  bool ready_ = false;
};

}  // namespace

template <class Scalar>
BodiesSideBySide<Scalar> side_by_side(std::span<const Scene> bodies, int lanes) {
  const Scene& first = bodies.front();
  const auto h = static_cast<Scalar>(step_of_map(first));
  const Packing packing = packing_of(first);
  BodiesSideBySide<Scalar> out{
      first.dimension(), first.has_frame(), first.arithmetic(), first.substeps(), h, {}, {}, {}};
  for (std::size_t k = 0; k < static_cast<std::size_t>(lanes); ++k) {
    const Scene& body = bodies[std::min(k, bodies.size() - 1)];
    if (packing == Packing::vector_field) {
      out.lambda.emplace_back(rounded_to<Scalar>(body.inertia()));
    } else if (packing == Packing::modified_inertia) {
      out.stages_3.resize(1);
      out.stages_3[0].push_back(modified_inertia(body, h));
    } else if (first.dimension() == 3) {
      add_stages<PrincipalMoments3<Extended<Scalar>>>(body, h, out.stages_3);
    } else {
      add_stages<PairSums4<Extended<Scalar>>>(body, h, out.stages_4);
    }
  }
  return out;
}

template BodiesSideBySide<float> side_by_side(std::span<const Scene>, int);
template BodiesSideBySide<double> side_by_side(std::span<const Scene>, int);

template <class Scalar>
std::unique_ptr<PackedBodies> pack_bodies_in(std::span<const Scene> bodies) {
  const auto together = side_by_side<Scalar>(bodies, lanes_of(bodies.front()));
#ifdef STIEFEL_X86_64
  if (widest_isa() == Isa::avx512) return pack_bodies_on<Isa::avx512>(together);
  return pack_bodies_on<Isa::avx2>(together);
#else
  return pack_bodies_on<Isa::baseline>(together);
#endif
}

std::unique_ptr<PackedBodies> pack_bodies(std::span<const Scene> bodies) {
  return bodies.front().in_float() ? pack_bodies_in<float>(bodies) : pack_bodies_in<double>(bodies);
}

std::unique_ptr<PackedBodies> pack(std::span<const Scene> bodies, std::span<const double> start) {
  if (is_exact_body(bodies.front())) return std::make_unique<PackedClosedForms>(bodies, start);
  return pack_bodies(bodies);
}

const Packs body_packs = {takes, takes_body, lanes_of, pack};

}  // namespace stiefel
