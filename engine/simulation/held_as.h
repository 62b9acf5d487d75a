#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/simulation/scene.h"
#include "engine/simulation/simulation.h"

namespace stiefel {

/// A Readout, which reads a `Form::Wide`, for states that are held as a `Form::Point`.
template <class Form, class Readout>
class HeldAs {
 public:
  using Point = typename Form::Point;

  explicit HeldAs(Readout readout) : readout_(std::move(readout)) {}

  const std::vector<Field>& fields() const { return readout_.fields(); }
  std::size_t block_count() const { return readout_.block_count(); }
  Point start(const Scene& scene) const { return Form::held(readout_.start(scene)); }
  void write(const Point& x, std::size_t index, std::span<double> out) const {
    readout_.write(Form::wide(x), index, out);
  }
  void invariants(const Point& x, InvariantList& out) const {
    readout_.invariants(Form::wide(x), out);
  }
  std::optional<double> orthogonality(const Point& x) const {
    return readout_.orthogonality(Form::wide(x));
  }
  double rate(const Point& x) const { return readout_.rate(Form::wide(x)); }

  /// A state near the manifold as a matrix, and back.
  Point point(const Eigen::MatrixXd& x)
      const requires std::is_same_v<typename Form::Wide, Eigen::MatrixXd> {
    return Form::held(x);
  }
  Eigen::MatrixXd stacked(
      const Point& x) const requires std::is_same_v<typename Form::Wide, Eigen::MatrixXd> {
    return Form::wide(x);
  }

 private:
  Readout readout_;
};

}  // namespace stiefel
