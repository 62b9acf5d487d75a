#pragma once

#include "engine/body/rigid_body_maps.h"
#include "engine/frame/stiefel_maps.h"
#include "methods/all_methods.h"
#include "tests/extremes/twin/twin.h"

namespace stiefel::extremes {

/// A twin that consists of a map and its state. `read(x)` returns the MotionState of a state x,
/// `energy(x)` its energy.
template <class Map, class Read, class Energy>
class TwinOf final : public Twin {
 public:
  TwinOf(Map map, const typename Map::Point& start, Read read, Energy energy)
      : map_(std::move(map)),
        state_(map_.start(start)),
        read_(std::move(read)),
        energy_(std::move(energy)),
        energy_at_start_(energy_(start)) {}

  RunStatus advance(std::int64_t steps) override {
    for (; steps > 0; --steps)
      if (const RunStatus run_status = map_.step(state_); !run_status.reached()) return run_status;
    return {};
  }
  MotionState state() const override { return read_(state_.x.value); }
  double energy_error() const override {
    return static_cast<double>(energy_(state_.x.value) / energy_at_start_ - 1);
  }

 private:
  Map map_;
  typename Map::State state_;
  Read read_;
  Energy energy_;
  typename Map::Point::Scalar energy_at_start_;
};

/// Returns the twin of `system` with the scene's method; a scene of `moser_veselov`, which has
/// none, gets `variational`.
template <class S, class Read, class Energy>
std::unique_ptr<Twin> twin_of(const Scene& scene, const S& system, const typename S::State& start,
                              Read read, Energy energy) {
  using Scalar = typename S::Scalar;
  std::unique_ptr<Twin> made;
  const bool discrete = scene.method().empty();
  const std::string name = discrete ? "variational" : scene.method();
  const auto attempt = [&]<class Method>(Method*) {
    if constexpr (applies<Method, S> && Method::traits.default_tolerance == 0)
      if (name == Method::traits.name) {
        made = std::make_unique<TwinOf<MapOf<Method, S>, Read, Energy>>(
            map_of(Method(), system, Scalar(scene.step()) / scene.substeps(),
                   {discrete ? 2 : scene.order(), Arithmetic::plain}),
            start, read, energy);
      }
  };
  for_each_type(Methods{}, attempt);
  return made;
}

/// Changes each number at random by up to `size` times the number.
class Perturbation {
 public:
  Perturbation(double size, unsigned seed) : size_(size), state_(seed * 2654435761u + 1) {}

  template <class Scalar, class Derived>
  Matrix<Scalar> of(const Eigen::MatrixBase<Derived>& x) {
    Matrix<Scalar> moved = x.template cast<Scalar>();
    if (size_ > 0)
      for (Scalar& number : moved.reshaped()) number += number * Scalar(size_ * uniform());
    return moved;
  }
  /// Changes a skew matrix, of which it uses the upper half.
  template <class Scalar>
  Matrix<Scalar> of_skew(const Eigen::MatrixXd& M) {
    const Matrix<Scalar> upper = of<Scalar>(M).template triangularView<Eigen::StrictlyUpper>();
    return upper - upper.transpose();
  }

 private:
  double uniform() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state_ >> 11) * 0x1p-52 - 1;
  }

  double size_;
  std::uint64_t state_;
};

// Each space has its own translation unit.
std::unique_ptr<Twin> twin_in_three(const Scene& scene, Perturbation moved);
std::unique_ptr<Twin> twin_in_many(const Scene& scene, Perturbation moved);
std::unique_ptr<Twin> twin_in_many_wide(const Scene& scene, Perturbation moved);
std::unique_ptr<Twin> twin_of_frames(const Scene& scene, Perturbation moved);

}  // namespace stiefel::extremes
