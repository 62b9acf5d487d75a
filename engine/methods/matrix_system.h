#pragma once

#include <functional>
#include <memory>

#include "engine/methods/concepts.h"
#include "stiefel/stop.h"

namespace stiefel {

/// A system whose states are matrices of any size.
template <class S>
concept HasMatrixStates = System<S> && std::same_as<typename S::State, Matrix<typename S::Scalar>>;

/// Any system with matrices as states, known by what it computes. A general method is compiled
/// once, for this class, instead of once for each system. A call costs far less than a product of
/// matrices. Copies share the system and its workspace. Each function but `zero` checks for a stop
/// request first.
template <class Scalar_>
class MatrixSystem {
 public:
  static constexpr const char* name = "any";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;
  using Algebra = Matrix<Scalar>;

  template <HasMatrixStates S>
  requires(!std::same_as<S, MatrixSystem>) MatrixSystem(S of) {
    const auto system = std::make_shared<S>(std::move(of));
    field_ = [system](const State& x, State& dx) { system->field(x, dx); };
    if constexpr (requires(State & x) { system->project(x); })
      project_ = [system](State& x) { system->project(x); };
    if constexpr (LieSystem<S>) {
      zero_ = system->zero();
      generator_ = [system](const State& x, Algebra& xi) { system->generator(x, xi); };
      bracket_ = [system](const Algebra& a, const Algebra& b, Algebra& c) {
        system->bracket(a, b, c);
      };
      displacement_ = [system](const State& x, const Algebra& theta, State& dx) {
        system->displacement(x, theta, dx);
      };
    }
  }

  void field(const State& x, State& dx) {
    stop_point(products(x, 1));
    field_(x, dx);
  }
  /// Projects x onto the manifold of the system's states, if the system has one.
  void project(State& x) {
    stop_point(products(x, 1));
    if (project_) project_(x);
  }

  // Of a LieSystem:
  const Algebra& zero() const { return zero_; }
  void generator(const State& x, Algebra& xi) {
    stop_point(products(x, 1));
    generator_(x, xi);
  }
  void bracket(const Algebra& a, const Algebra& b, Algebra& c) const {
    stop_point(products(a, 1));
    bracket_(a, b, c);
  }
  void displacement(const State& x, const Algebra& theta, State& dx) {
    stop_point(products(theta, 10));  // eight of these ten products are the exponential
    displacement_(x, theta, dx);
  }

 private:
  /// Returns the number of operations of `count` products of square matrices with x.
  static double products(const Matrix<Scalar>& x, int count) {
    return static_cast<double>(count * x.rows() * x.rows() * x.cols());
  }

  std::function<void(const State&, State&)> field_, generator_;
  std::function<void(State&)> project_;
  std::function<void(const Algebra&, const Algebra&, Algebra&)> bracket_;
  std::function<void(const State&, const Algebra&, State&)> displacement_;
  Algebra zero_;
};

}  // namespace stiefel
