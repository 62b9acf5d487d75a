#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/numbers/scalar.h"
#include "engine/stepping/invariant_list.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// Holds Observables of states that are matrices of any size, and calls them virtually.
template <class Scalar>
class MatrixObservables {
 public:
  using Point = Matrix<Scalar>;

  template <class Observables>
  requires(!std::derived_from<Observables, MatrixObservables>) explicit MatrixObservables(
      Observables observables)
      : held_(std::make_shared<Held<Observables>>(std::move(observables))) {}

  const std::vector<Field>& fields() const { return held_->fields(); }
  std::size_t block_count() const { return held_->block_count(); }
  Point start(const Scene& scene) const { return held_->start(scene); }
  void write(const Point& x, std::size_t index, std::span<double> out) const {
    held_->write(x, index, out);
  }
  void invariants(const Point& x, InvariantList& out) const { held_->invariants(x, out); }
  std::optional<double> orthogonality(const Point& x) const { return held_->orthogonality(x); }
  double rate(const Point& x) const { return held_->rate(x); }
  Point point(const Eigen::MatrixXd& x) const { return rounded_to<Scalar>(x); }
  Eigen::MatrixXd stacked(const Point& x) const { return x.template cast<double>(); }

 private:
  struct Abstract {
    virtual ~Abstract() = default;
    virtual const std::vector<Field>& fields() const = 0;
    virtual std::size_t block_count() const = 0;
    virtual Point start(const Scene& scene) const = 0;
    virtual void write(const Point& x, std::size_t index, std::span<double> out) const = 0;
    virtual void invariants(const Point& x, InvariantList& out) const = 0;
    virtual std::optional<double> orthogonality(const Point& x) const = 0;
    virtual double rate(const Point& x) const = 0;
  };
  template <class Observables>
  struct Held final : Abstract {
    explicit Held(Observables o) : observables(std::move(o)) {}
    const std::vector<Field>& fields() const override { return observables.fields(); }
    std::size_t block_count() const override { return observables.block_count(); }
    Point start(const Scene& scene) const override { return observables.start(scene); }
    void write(const Point& x, std::size_t index, std::span<double> out) const override {
      observables.write(x, index, out);
    }
    void invariants(const Point& x, InvariantList& out) const override {
      observables.invariants(x, out);
    }
    std::optional<double> orthogonality(const Point& x) const override {
      return observables.orthogonality(x);
    }
    double rate(const Point& x) const override { return observables.rate(x); }
    Observables observables;
  };
  std::shared_ptr<const Abstract> held_;
};

}  // namespace stiefel
