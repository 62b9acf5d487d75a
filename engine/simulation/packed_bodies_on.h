#pragma once

#include "engine/maps/discrete_bodies_3.h"
#include "engine/methods/rk4.h"
#include "engine/simulation/packed_bodies.h"
#include "engine/systems/rigid_body.h"

namespace stiefel {

/// PackedBodies by a map of packs.
template <class P, class Map>
class PackedBodiesOn final : public PackedBodies {
 public:
  PackedBodiesOn(Map map, int substeps) : map_(std::move(map)), substeps_(substeps) {}

  int lanes() const override { return P::lanes; }

  Progress advance(std::span<double> states, std::int64_t steps) override {
    double* numbers = states.data();
    const auto stride = static_cast<std::ptrdiff_t>(states.size()) / P::lanes;
    State x{}, before{};
    each_number(x, [&](P& number, std::ptrdiff_t i) { number = P::gather(numbers + i, stride); });
    std::int64_t step = 0;
    unsigned further = 0;
    for (; step < steps; ++step) {
      before = x;
      auto easy = map_.step_where_easy(x);
      for (int k = 1; k < substeps_; ++k) easy = easy & map_.step_where_easy(x);
      if (all(easy)) continue;
      further = easy.lanes_set();
      break;
    }
    const auto write = [&](State& from, unsigned lanes) {
      each_number(from,
                  [&](P& number, std::ptrdiff_t i) { number.scatter(numbers + i, stride, lanes); });
    };
    write(x, step < steps ? further : every_lane);
    if (step < steps) write(before, every_lane & ~further);
    return {step, further};
  }

 private:
  using State = typename Map::State;
  static constexpr unsigned every_lane = P::Mask::every_lane;

  template <class Visit>
  static void each_number(State& x, Visit&& visit) {
    std::ptrdiff_t at = 0;
    x.each([&](auto& block) {
      for (Eigen::Index i = 0; i < block.size(); ++i) visit(block(i), at++);
    });
  }

  Map map_;
  int substeps_;
};

template <Isa isa>
std::unique_ptr<PackedBodies> pack_bodies_on(const BodiesSideBySide& bodies) {
  using P = Pack<double, isa, vector_width(isa)>;
  std::unique_ptr<PackedBodies> packed;
  const auto make = [&]<bool frame, Arithmetic arithmetic>() {
    if (!bodies.lambda.empty()) {
      using Body = RigidBody<So3<P, frame>>;
      using Map = Rk4::Map<Body, arithmetic>;
      Vector3<P> lambda;
      for (int i = 0; i < 3; ++i)
        lambda(i) = P::of_lanes([&](int k) { return bodies.lambda[k].data()[i]; });
      packed = std::make_unique<PackedBodiesOn<P, Map>>(Map(Body(lambda), P(bodies.h), 4),
                                                        bodies.substeps);
    } else {
      using Map = DiscreteBodies3<P, frame, arithmetic>;
      std::vector<DiscreteInertia3<P>> stages;
      for (const auto& stage : bodies.stages) stages.emplace_back(stage.data());
      packed = std::make_unique<PackedBodiesOn<P, Map>>(Map(std::move(stages)), bodies.substeps);
    }
  };
  const auto with_frame = [&]<bool frame>() {
    if (bodies.arithmetic == Arithmetic::plain)
      make.template operator()<frame, Arithmetic::plain>();
    else
      make.template operator()<frame, Arithmetic::compensated>();
  };
  if (bodies.frame)
    with_frame.template operator()<true>();
  else
    with_frame.template operator()<false>();
  return packed;
}

}  // namespace stiefel
