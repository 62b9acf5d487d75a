#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/motion/invariant_list.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// What can be read of a state. A point is the state of a system as a matrix of doubles: its blocks
/// stacked by rows, or, for bodies in three dimensions, (q; m) or m alone as a column.
class Observables {
 public:
  using Point = Eigen::MatrixXd;

  virtual ~Observables() = default;

  /// Returns the fields that the scene offers; the system's blocks come first.
  const std::vector<Field>& fields() const { return fields_; }
  std::size_t block_count() const { return block_count_; }

  /// Returns the point at step 0.
  virtual Point start(const Scene& scene) const = 0;
  virtual void write(const Point& x, std::size_t index, std::span<double> out) const = 0;
  virtual void invariants(const Point& x, InvariantList& out) const = 0;
  virtual std::optional<double> orthogonality(const Point& x) const = 0;
  virtual double rate(const Point& x) const = 0;

  /// Convert a point near the manifold from blocks stacked by rows, and to them.
  virtual Point from_blocks(const Eigen::MatrixXd& blocks) const { return blocks; }
  virtual Eigen::MatrixXd to_blocks(const Point& x) const { return x; }

 protected:
  std::vector<Field> fields_;
  std::size_t block_count_ = 0;
};

using SharedObservables = std::shared_ptr<const Observables>;

template <std::derived_from<Observables> Kind>
SharedObservables shared(Kind observables) {
  return std::make_shared<const Kind>(std::move(observables));
}

}  // namespace stiefel
