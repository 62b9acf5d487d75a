#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include "stiefel/scene.h"

#include "engine/numbers/dual.h"
#include "stiefel/run_status.h"

namespace stiefel {

/// A number of a state with its derivatives along the tangent vectors that move together.
using Tangent = Dual<double, 4>;

/// The derivative of a scene's computed step, applied to tangent vectors: up to `lanes` in dual
/// numbers, any number in maps by columns (Tangents). Beside the state, the inertia and the step
/// may have derivatives, so that the vectors become derivatives of the state with respect to them.
///
/// A vector has the shape of the state's blocks stacked by rows (2N × N for (Q, M)) and is a column
/// of V, column by column. A point is that of Observables.
class TangentMap {
 public:
  static constexpr int lanes = Tangent::lanes;

  virtual ~TangentMap() = default;

  /// Sets the vectors at a point.
  virtual void start(const Eigen::MatrixXd& point, const Eigen::MatrixXd& V) = 0;
  /// Moves the vectors from `point` by one step of the scene, which the simulation has made too.
  virtual RunStatus step(const Eigen::MatrixXd& point) = 0;
  /// Whether `at` moves the vectors from the start by k steps at once; `step` is then not used.
  virtual bool direct() const = 0;
  virtual RunStatus at(std::int64_t k) = 0;
  /// Writes the vectors at `point`, the state that they have reached.
  virtual void read(const Eigen::MatrixXd& point, Eigen::MatrixXd& V) const = 0;
};

/// What the tangents of a scene depend on: Λ and the step of the map, with derivatives.
struct TangentParameters {
  Vector<Tangent> lambda;
  Tangent h;
};

/// What a map by columns depends on: Λ and the step of the map, and their derivatives along each
/// vector, a column of `by_lambda` and a number of `by_h`.
struct ColumnParameters {
  Eigen::VectorXd lambda;
  double h = 0;
  Eigen::MatrixXd by_lambda;
  Eigen::VectorXd by_h;

  bool constant() const { return by_lambda.isZero(0) && by_h.isZero(0); }
};

/// The tangent spaces of a scene's states.
struct TangentSpace {
  using Dense = Eigen::MatrixXd;
  /// The coordinates: (η, δM) with δQ = Qη or δQ = ηQ, or those of an orthonormal basis.
  enum class Coordinates { left_body, right_body, orthonormal };
  Coordinates coordinates = Coordinates::orthonormal;
  /// For orthonormal coordinates: returns the tangent part of any G at x, linear in G. x is the
  /// state's blocks stacked by rows.
  std::function<Dense(const Dense& x, const Dense& G)> tangent;
  /// Where the states there are depend on Λ, so that a state leaves its tangent space when Λ
  /// changes: the same for the states of every Λ together.
  std::function<Dense(const Dense& x, const Dense& G)> tangent_of_every_inertia = nullptr;
  /// And the derivatives by each λ_k of the state that a scene makes of the blocks of x, numbers
  /// column by column in column k.
  std::function<Dense(const Dense& x)> by_inertia = nullptr;
};

/// What gives the tangents of a system's scenes. Of a system NAME of systems.inc, NAME_tangents().
struct Tangents {
  TangentSpace (*space)(const Scene&) = nullptr;
  /// Returns null where the scene's method has no tangent.
  std::unique_ptr<TangentMap> (*make)(const Scene&, const TangentParameters&) = nullptr;
  /// Returns whether there is a map that moves all vectors by the linearised formula of the method,
  /// which solves for the values of a step once, and that map. Every vector has the bits that it
  /// has alone. The map of a large body takes long to make.
  bool (*has_columns)(const Scene&) = nullptr;
  std::unique_ptr<TangentMap> (*make_columns)(const Scene&, const ColumnParameters&) = nullptr;
};

}  // namespace stiefel
