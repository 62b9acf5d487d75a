#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/stepping/invariant_list.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// Applies observables that read a `Form::Wide` to states stored as a `Form::Point`.
template <class Form, class Observables>
class StoredAs {
 public:
  using Point = typename Form::Point;

  explicit StoredAs(Observables observables) : observables_(std::move(observables)) {}

  const std::vector<Field>& fields() const { return observables_.fields(); }
  std::size_t block_count() const { return observables_.block_count(); }
  Point start(const Scene& scene) const { return Form::to_stored(observables_.start(scene)); }
  void write(const Point& x, std::size_t index, std::span<double> out) const {
    observables_.write(Form::to_wide(x), index, out);
  }
  void invariants(const Point& x, InvariantList& out) const {
    observables_.invariants(Form::to_wide(x), out);
  }
  std::optional<double> orthogonality(const Point& x) const {
    return observables_.orthogonality(Form::to_wide(x));
  }
  double rate(const Point& x) const { return observables_.rate(Form::to_wide(x)); }

  /// Convert a state near the manifold from a matrix, and to one.
  Point point(const Eigen::MatrixXd& x)
      const requires std::is_same_v<typename Form::Wide, Eigen::MatrixXd> {
    return Form::to_stored(x);
  }
  Eigen::MatrixXd stacked(
      const Point& x) const requires std::is_same_v<typename Form::Wide, Eigen::MatrixXd> {
    return Form::to_wide(x);
  }

 private:
  Observables observables_;
};

}  // namespace stiefel
