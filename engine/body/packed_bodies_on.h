#pragma once

#include <algorithm>
#include <vector>

#include "engine/body/body_packs.h"
#include "engine/body/j_d/discrete_body_3.h"
#include "engine/body/j_d/discrete_body_4.h"
#include "engine/body/rigid_body.h"
#include "engine/methods/rk4.h"
#include "engine/numbers/pack.h"

namespace stiefel {

/// Discrete rigid bodies in the lanes of vector registers, one in each lane: the map of order 2,
/// its symmetric compositions, and, with modified moments, PreprocessedMoserVeselov. A lane is easy
/// when every stage finds its solution by the iteration for packs. `Body` is DiscreteBody3 or
/// DiscreteBody4.
template <class Body>
class DiscreteBodies {
 public:
  using Inertia = typename Body::Inertia;

  struct State {
    typename Body::State x;

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
    }
  };

  /// `stages` is the first half of the palindromic sequence of stages, including the middle one.
  /// They must outlive the map and its copies.
  DiscreteBodies(std::span<const Inertia> stages, bool moves_frame)
      : stages_(stages), body_(moves_frame) {}

  /// Makes the step in the easy lanes and returns them. The states in the other lanes become
  /// undefined.
  auto step_where_easy(State& state) {
    const std::size_t count = 2 * stages_.size() - 1;
    auto easy = stages_.front().positive;
    for (std::size_t stage = 0; stage < count; ++stage) {
      const Inertia& I = stages_[std::min(stage, count - 1 - stage)];
      easy = easy & body_.solve_where_easy(state.x, I);
      body_.transport(state.x, I);
    }
    return easy;
  }

 private:
  std::span<const Inertia> stages_;
  Body body_;
};

/// Implements PackedBodies by a map of packs. It is made anew for each call, because it has a
/// workspace: Bodies holds what it is made from, Bodies::map().
template <class P, class Bodies>
class PackedBodiesOn final : public PackedBodies {
 public:
  PackedBodiesOn(Arithmetic arithmetic, int substeps, Bodies bodies)
      : bodies_(std::move(bodies)),
        compensated_(arithmetic == Arithmetic::compensated),
        substeps_(substeps) {}

  int lanes() const override { return P::lanes; }

  Progress advance(std::span<double> states, std::int64_t steps) const override {
    auto map = bodies_.map();
    double* numbers = states.data();
    const auto stride = static_cast<std::ptrdiff_t>(states.size()) / P::lanes;
    State x{}, before{};
    x.x.compensated = before.x.compensated = compensated_;
    each_number(x, [&](P& number, std::ptrdiff_t i) { number = P::gather(numbers + i, stride); });
    std::int64_t step = 0;
    unsigned further = every_lane;
    for (int k = 0; step < steps;) {
      if (k == 0) before.x.assign(x.x);
      further &= map.step_where_easy(x).lanes_set();
      if (++k < substeps_) continue;
      if (further != every_lane) break;
      k = 0;
      ++step;
    }
    const auto write = [&](State& from, unsigned lanes) {
      each_number(from,
                  [&](P& number, std::ptrdiff_t i) { number.scatter(numbers + i, stride, lanes); });
    };
    write(x, further);
    if (further != every_lane) write(before, every_lane & ~further);
    return {step, further};
  }

 private:
  using State = typename Bodies::Map::State;
  static constexpr unsigned every_lane = P::Mask::every_lane;

  template <class Visit>
  static void each_number(State& x, Visit&& visit) {
    std::ptrdiff_t at = 0;
    x.each([&](auto& block) {
      for (Eigen::Index i = 0; i < block.size(); ++i) visit(block(i), at++);
    });
  }

  Bodies bodies_;
  bool compensated_;
  int substeps_;
};

/// The types for bodies of packs P in N dimensions. They have the states of the Simulations of one
/// body: that of a discrete body always holds Q.
template <class P, int N>
struct BodyOf;
template <class P>
struct BodyOf<P, 3> {
  template <bool frame>
  using Space = So3<P, frame>;
  using Discrete = DiscreteBody3<P, true>;
  static const auto& stages(const auto& bodies) { return bodies.stages_3; }
};
template <class P>
struct BodyOf<P, 4> {
  template <bool frame>
  using Space = So4<P, frame>;
  using Discrete = DiscreteBody4<P, true>;
  static const auto& stages(const auto& bodies) { return bodies.stages_4; }
};

/// The only method with Packing::vector_field. A second one would need its name in
/// BodiesSideBySide.
using OfVectorField = Rk4;
static_assert(OfVectorField::traits.packing == Packing::vector_field);

/// Bodies that move by the vector field, with the λ of each.
template <class P, class Space>
struct BodiesByField {
  using Body = RigidBody<Space>;
  using Map = OfVectorField::Map<Body>;

  explicit BodiesByField(const BodiesSideBySide<typename P::Scalar>& bodies) : h(bodies.h) {
    for (int i = 0; i < lambda.size(); ++i)
      lambda(i) = P::of_lanes([&](int k) { return bodies.lambda[k].data()[i]; });
  }
  Map map() const { return {Body(lambda), h, OfVectorField::traits.default_order}; }

  typename Body::Lambda lambda;
  P h;
};

/// Bodies that move by the stages of the discrete body.
template <class Body>
struct BodiesByStages {
  using Map = DiscreteBodies<Body>;

  template <class Stages>
  BodiesByStages(const Stages& in_lanes, bool with_frame) : frame(with_frame) {
    stages.reserve(in_lanes.size());
    for (const auto& stage : in_lanes) stages.emplace_back(stage.data());
  }
  Map map() const { return {stages, frame}; }

  std::vector<typename Body::Inertia> stages;
  bool frame;
};

template <Isa isa, int N, class Scalar>
std::unique_ptr<PackedBodies> pack_bodies_on(const BodiesSideBySide<Scalar>& bodies) {
  using P = Pack<Scalar, isa, vector_width<Scalar>(isa)>;
  using These = BodyOf<P, N>;
  const auto packed = [&](auto data) -> std::unique_ptr<PackedBodies> {
    return std::make_unique<PackedBodiesOn<P, decltype(data)>>(bodies.arithmetic, bodies.substeps,
                                                               std::move(data));
  };
  if (bodies.lambda.empty())
    return packed(BodiesByStages<typename These::Discrete>(These::stages(bodies), bodies.frame));
  if (bodies.frame) return packed(BodiesByField<P, typename These::template Space<true>>(bodies));
  return packed(BodiesByField<P, typename These::template Space<false>>(bodies));
}

}  // namespace stiefel
