#include "engine/body/body_packs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/body/exact_body.h"
#include "engine/body/preprocessed_moser_veselov.h"
#include "engine/body/reports_3.h"
#include "engine/dense/euler_angles.h"
#include "engine/dense/principal_moments_3.h"
#include "engine/dense/so_4.h"
#include "engine/methods/symmetric_stages.h"
#include "engine/motion/body_view.h"
#include "engine/motion/flat_bodies.h"
#include "engine/motion/given_members.h"
#include "engine/motion/method_entry.h"
#include "engine/numbers/parallel.h"

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

/// Returns the bodies in their lanes.
template <class Element, class Make>
std::vector<Element> in_lanes(std::span<const PackedBody> bodies, int lanes, const Make& make) {
  std::vector<Element> all;
  all.reserve(static_cast<std::size_t>(lanes));
  for (std::size_t k = 0; k < static_cast<std::size_t>(lanes); ++k)
    all.push_back(make(bodies[std::min(k, bodies.size() - 1)]));
  return all;
}

int lanes_of(const Scene& scene) {
  return scene.in_float() ? vector_width<float>(widest_isa()) : vector_width<double>(widest_isa());
}

/// Whether products of the numbers of a body with the step of `like` stay normal.
template <class Lambda, class Momentum>
bool stays_normal(const Scene& like, const Lambda& lambda, const Momentum& M) {
  const auto is_normal = [in_float = like.in_float()](double x) {
    return is_far_from_ends(x, in_float);
  };
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

/// Bodies in three dimensions by the method `exact`. Those without a motion in theta functions are
/// left to their own Simulations.
class PackedClosedForms final : public PackedBodies {
 public:
  PackedClosedForms(const Scene& like, std::vector<TopInTime> bodies)
      : bodies_(std::move(bodies)),
        unit_(like.step() / like.substeps()),
        substeps_(like.substeps()) {
    const auto some =
        std::ranges::find_if(bodies_, [](TopInTime& body) { return body.theta().has_value(); });
    for (int lane = 0; lane < lanes() && some != bodies_.end(); ++lane) {
      TopInTime& body = bodies_[std::min<std::size_t>(lane, bodies_.size() - 1)];
      side_by_side_.put(lane, body.theta() ? *body.theta() : *some->theta());
    }
  }

  int lanes() const override { return ThetaTop::lanes(); }

  Progress advance(std::span<double> states, std::int64_t steps) const override {
    const std::size_t each = states.size() / static_cast<std::size_t>(lanes());
    ThetaTop::Times times{.unit = unit_, .high = {}, .low = {}};
    const auto all = static_cast<unsigned>(lanes());
    unsigned easy = 0;
    for (unsigned lane = 0; lane < all; ++lane) {
      const double k = states[lane * each + each - 1] + static_cast<double>(steps) * substeps_;
      const auto& theta = body(lane).theta_found();
      times.high[lane] = k;
      const auto time = static_cast<double>(static_cast<long double>(k) * unit_);
      if (theta && std::abs(k) < largest && theta->takes(time)) easy |= 1u << lane;
    }
    if (easy == 0) return {0, 0};
    ThetaTop::Lanes found;
    side_by_side_.at(times, found);
    for (unsigned lane = 0; lane < all; ++lane) {
      if (!(easy >> lane & 1)) continue;
      const auto x = body(lane).rounded(found, static_cast<int>(lane));
      const auto to = states.subspan(lane * each, each);
      std::ranges::copy(x.tail(static_cast<Eigen::Index>(each) - 1), to.begin());
      to.back() = times.high[lane];
    }
    if (easy == (1u << lanes()) - 1) return {steps, 0};
    return {0, easy};
  }

 private:
  static constexpr double largest = 0x1p53;  ///< numbers of steps below are exact

  const TopInTime& body(std::size_t lane) const {
    return bodies_[std::min(lane, bodies_.size() - 1)];
  }

  std::vector<TopInTime> bodies_;
  ThetaTops side_by_side_;
  double unit_;
  int substeps_;
};

template <class Scalar>
std::unique_ptr<PackedBodies> pack_bodies_in(const Scene& like,
                                             std::span<const PackedBody> bodies) {
  const auto together = side_by_side<Scalar>(like, bodies, lanes_of(like));
#ifdef STIEFEL_X86_64
  if (widest_isa() == Isa::avx512) return pack_bodies_on<Isa::avx512>(together);
  return pack_bodies_on<Isa::avx2>(together);
#else
  return pack_bodies_on<Isa::baseline>(together);
#endif
}

/// Bodies of (Q, M) in three dimensions.
class FlatBodies3 final : public FlatBodies {
 public:
  explicit FlatBodies3(const Scene& scene)
      : FlatBodies(scene),
        like_(ensemble().members().front()),
        reports_(like_),
        saved_(first().saved_size()),
        bodies_(size()) {
    const double nanoseconds = 200 * static_cast<double>(size());
    std::vector<char> packable(size());
    const bool exact = is_exact_body(like_);
    in_ranges(std::ssize(bodies_), 256, nanoseconds, [&](auto from, auto end) {
      GivenMembers given(ensemble().description(), like_);
      for (auto b = static_cast<std::size_t>(from); b < static_cast<std::size_t>(end); ++b) {
        stop_point();
        const auto found = given.any() ? given[b] : std::nullopt;
        bodies_[b] = Reported3(found ? *found : body_3(ensemble().members()[b]));
        packable[b] = exact || stays_normal(like_, bodies_[b].lambda, hat(bodies_[b].m));
      }
    });
    std::vector<std::size_t> together;
    for (std::size_t b = 0; b < size(); ++b)
      if (packable[b]) together.push_back(b);
    pack_all(std::move(together), lanes_of(like_));
  }

  void start(std::size_t b, std::span<double> state) const override {
    const Body3& body = bodies_[b];
    const auto put = [in_float = like_.in_float()](const auto& numbers, double* to) {
      if (in_float)
        std::ranges::copy(rounded_to<float>(numbers), to);
      else
        std::ranges::copy(numbers, to);
    };
    std::ranges::fill(state, 0);
    put(body.m, state.data() + point_end() - 3);
    if (body.has_frame) put(body.attitude, state.data());
  }

  void write(std::size_t b, std::span<const double> state, std::size_t index,
             std::span<double> out) const override {
    const std::vector<Field>& listed = first().fields();
    if (index < listed.size()) return reports_.write(bodies_[b], point(state), index, out);
    Eigen::Vector4d q;
    Eigen::Vector3d omega;
    write(b, state, *find_field(listed, "quaternion"), {q.data(), 4});
    write(b, state, *find_field(listed, "angular_velocity"), {omega.data(), 3});
    Eigen::Map<Eigen::Vector3d>(out.data()) =
        EulerField::with_code(index - listed.size()).value(q, omega);
  }
  void invariants(std::size_t b, std::span<const double> state, InvariantList& out) const override {
    reports_.invariants(bodies_[b], point(state), out);
  }
  std::optional<double> orthogonality(std::size_t b, std::span<const double> state) const override {
    return reports_.orthogonality(bodies_[b], point(state));
  }
  double rate(std::size_t b, std::span<const double> state) const override {
    return reports_.rate(bodies_[b], point(state));
  }

 private:
  std::shared_ptr<const PackedBodies> make_pack(
      std::span<const std::size_t> members) const override {
    if (is_exact_body(like_)) {
      std::vector<TopInTime> tops;
      tops.reserve(members.size());
      for (const std::size_t b : members) tops.push_back(top(b));
      return std::make_shared<PackedClosedForms>(like_, std::move(tops));
    }
    std::vector<PackedBody> some(members.size());
    for (std::size_t k = 0; k < some.size(); ++k) {
      some[k].lambda << bodies_[members[k]].lambda, 0;
      some[k].m = bodies_[members[k]].m;
    }
    return pack_bodies(like_, some);
  }

  /// Returns where the point (q; m) or m of a state ends; carries, or the number of steps, follow.
  std::size_t point_end() const { return saved_ < 7 ? 3 : 7; }
  const double* point(std::span<const double> state) const {
    return state.data() + point_end() - static_cast<std::size_t>(reports_.size());
  }
  TopInTime top(std::size_t b) const {
    const Body3& body = bodies_[b];
    std::optional<ExtendedBody> given;
    if (body.axes)
      given =
          extended_body(GivenBody(*ensemble().description().body, b, size()), *body.axes, body.m);
    Eigen::Matrix<double, 7, 1> start;
    start << body.attitude, body.m;
    const auto size = static_cast<std::size_t>(reports_.size());
    return top_in_time(body.lambda, given, std::span(start.data(), 7).last(size));
  }

  const Scene like_;
  Reports3 reports_;
  std::size_t saved_;
  std::vector<Reported3> bodies_;
};

bool is_flat(const Scene& ensemble) {
  const bool moves = is_exact_body(ensemble) || packing_of(ensemble) != Packing::none;
  return has_packs() && ensemble.dimension() == 3 && moves &&
         !system_entry(ensemble.system())->view;
}
std::shared_ptr<const FlatBodies> flat(const Scene& ensemble) {
  return std::make_shared<FlatBodies3>(ensemble);
}

std::unique_ptr<PackedBodies> pack(std::span<const Scene> scenes, std::span<const double> start) {
  if (is_exact_body(scenes.front())) {
    const std::size_t each = start.size() / scenes.size();
    std::vector<TopInTime> tops;
    for (std::size_t k = 0; k < scenes.size(); ++k)
      tops.push_back(top_in_time(scenes[k].inertia(), extended_body(scenes[k]),
                                 start.subspan(k * each, each - 1)));
    return std::make_unique<PackedClosedForms>(scenes.front(), std::move(tops));
  }
  std::vector<PackedBody> bodies;
  for (const Scene& scene : scenes) bodies.push_back(packed_body(scene));
  return pack_bodies(scenes.front(), bodies);
}

}  // namespace

PackedBody packed_body(const Scene& scene) {
  PackedBody body;
  body.lambda << scene.inertia(), Eigen::VectorXd::Zero(4 - scene.dimension());
  if (scene.dimension() == 3) body.m = vee(body_momentum(scene));
  return body;
}

template <class Scalar>
BodiesSideBySide<Scalar> side_by_side(const Scene& like, std::span<const PackedBody> bodies,
                                      int lanes) {
  using Wide = Extended<Scalar>;
  const auto h = static_cast<Scalar>(step_of_map(like));
  const int N = like.dimension();
  BodiesSideBySide<Scalar> out{N, like.has_frame(), like.arithmetic(), like.substeps(), h, {}, {},
                               {}};
  const auto lambda = [](const PackedBody& body) { return rounded_to<Scalar>(body.lambda); };
  const Packing packing = packing_of(like);
  if (packing == Packing::vector_field) {
    out.lambda = in_lanes<typename decltype(out.lambda)::value_type>(bodies, lanes, lambda);
  } else if (packing == Packing::modified_inertia) {
    std::optional<ModifiedJDInverse3<Scalar, false>> inverse;  // of consecutive bodies with one λ
    const PackedBody* before = nullptr;
    out.stages_3.push_back(
        in_lanes<DiscreteInertia3<Scalar>>(bodies, lanes, [&](const PackedBody& body) {
          if (!before || before->lambda != body.lambda)
            inverse.emplace(lambda(body).template head<3>(), h, like.order());
          before = &body;
          return inverse->memory(rounded_to<Scalar>(body.m));
        }));
  } else {
    for (const Scalar gamma : symmetric_stages<Scalar>(std::max(like.order(), 2)))
      if (N == 3)
        out.stages_3.push_back(
            in_lanes<DiscreteInertia3<Scalar>>(bodies, lanes, [&](const PackedBody& body) {
              return DiscreteInertia3<Scalar>(
                  PrincipalMoments3<Wide>(lambda(body).template head<3>()), gamma * h);
            }));
      else
        out.stages_4.push_back(
            in_lanes<DiscreteInertia4<Scalar>>(bodies, lanes, [&](const PackedBody& body) {
              return DiscreteInertia4<Scalar>(PairSums4<Wide>(lambda(body)), gamma * h);
            }));
  }
  return out;
}

template BodiesSideBySide<float> side_by_side(const Scene&, std::span<const PackedBody>, int);
template BodiesSideBySide<double> side_by_side(const Scene&, std::span<const PackedBody>, int);

std::unique_ptr<PackedBodies> pack_bodies(const Scene& like, std::span<const PackedBody> bodies) {
  return like.in_float() ? pack_bodies_in<float>(like, bodies)
                         : pack_bodies_in<double>(like, bodies);
}

const Packs body_packs = {takes, lanes_of, pack, is_flat, flat};

}  // namespace stiefel
