#pragma once

#include <memory>

#include "engine/methods/concepts.h"
#include "stiefel/stop.h"

namespace stiefel {

/// A system whose states are matrices of any size.
template <class S>
concept HasMatrixStates = System<S> && std::same_as<typename S::State, Matrix<typename S::Scalar>>;

/// Returns the number of operations of a vector field: two products with the state, rows × cols.
template <class State>
double field_operations(const State& x) {
  return static_cast<double>(x.rows() * x.rows() * x.cols());
}

/// Any system with matrix states, known by its vector field alone. A method that needs only the
/// field is compiled once, for this class, instead of once for each system. The call is virtual,
/// which costs far less than a product of matrices. Copies share the system and its workspace.
template <class Scalar_>
class MatrixSystem {
 public:
  static constexpr const char* name = "any";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;

  template <HasMatrixStates S>
  requires(!std::derived_from<S, MatrixSystem>) MatrixSystem(S system)
      : held_(std::make_shared<Held<S>>(std::move(system))) {}

  /// Checks for a stop request, then computes the field.
  void field(const State& x, State& dx) {
    stop_point(field_operations(x));
    held_->field(x, dx);
  }

  /// Projects x onto the manifold of the system's states, if the system has one.
  void project(State& x) {
    stop_point(field_operations(x));
    held_->project(x);
  }

 private:
  struct Abstract {
    virtual ~Abstract() = default;
    virtual void field(const State& x, State& dx) = 0;
    virtual void project(State& x) = 0;
  };
  template <class S>
  struct Held final : Abstract {
    explicit Held(S s) : system(std::move(s)) {}
    void field(const State& x, State& dx) override { system.field(x, dx); }
    void project(State& x) override {
      if constexpr (requires { system.project(x); }) system.project(x);
    }
    S system;
  };
  std::shared_ptr<Abstract> held_;
};

/// Any LieSystem whose states and algebra are matrices, known by its vector field and group action.
/// Copies share the system and its workspace.
template <class Scalar_>
class MatrixLieSystem {
 public:
  static constexpr const char* name = "any";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;
  using Algebra = Matrix<Scalar>;

  template <HasMatrixStates S>
  requires(LieSystem<S> && !std::derived_from<S, MatrixLieSystem>) MatrixLieSystem(S system)
      : held_(std::make_shared<Held<S>>(std::move(system))) {}

  // Each of these functions but `zero` checks for a stop request first.
  void field(const State& x, State& dx) {
    stop_point(field_operations(x));
    held_->field(x, dx);
  }
  Algebra zero() const { return held_->zero(); }
  void generator(const State& x, Algebra& xi) {
    stop_point(field_operations(x));
    held_->generator(x, xi);
  }
  void bracket(const Algebra& a, const Algebra& b, Algebra& c) const {
    stop_point(products(a, 1));
    held_->bracket(a, b, c);
  }
  void displacement(const State& x, const Algebra& theta, State& dx) {
    stop_point(products(theta, 10));  // eight of these ten products are the exponential
    held_->displacement(x, theta, dx);
  }

 private:
  struct Abstract {
    virtual ~Abstract() = default;
    virtual void field(const State& x, State& dx) = 0;
    virtual Algebra zero() const = 0;
    virtual void generator(const State& x, Algebra& xi) = 0;
    virtual void bracket(const Algebra& a, const Algebra& b, Algebra& c) const = 0;
    virtual void displacement(const State& x, const Algebra& theta, State& dx) = 0;
  };
  template <class S>
  struct Held final : Abstract {
    explicit Held(S s) : system(std::move(s)) {}
    void field(const State& x, State& dx) override { system.field(x, dx); }
    Algebra zero() const override { return system.zero(); }
    void generator(const State& x, Algebra& xi) override { system.generator(x, xi); }
    void bracket(const Algebra& a, const Algebra& b, Algebra& c) const override {
      system.bracket(a, b, c);
    }
    void displacement(const State& x, const Algebra& theta, State& dx) override {
      system.displacement(x, theta, dx);
    }
    S system;
  };
  /// Returns the number of operations of `count` products of matrices of the size of a.
  static double products(const Algebra& a, int count) {
    return static_cast<double>(count * a.rows() * a.rows() * a.cols());
  }

  std::shared_ptr<Abstract> held_;
};

}  // namespace stiefel
