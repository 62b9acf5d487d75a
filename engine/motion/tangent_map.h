#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "engine/numbers/scalar.h"
#include "stiefel/run_status.h"
#include "stiefel/scene.h"

namespace stiefel {

/// The derivative of a scene's computed step, applied to any number of tangent vectors. Beside the
/// state, the inertia and the step may have derivatives, so that the vectors become derivatives of
/// the state with respect to them. Every vector has the bits that it has alone.
///
/// A vector has the shape of the state's blocks stacked by rows (2N × N for (Q, M)) and is a column
/// of V, column by column. A point is that of Observables.
class TangentMap {
 public:
  virtual ~TangentMap() = default;

  /// Sets the vectors at a point.
  virtual void start(const Eigen::MatrixXd& point, const Eigen::MatrixXd& V) = 0;
  /// Moves the vectors from `point` by one step of the scene, which the simulation has made too.
  virtual RunStatus step(const Eigen::MatrixXd& point) = 0;
  /// Whether `at` moves the vectors from the start by k steps at once; `step` is then not used.
  virtual bool direct() const { return false; }
  virtual RunStatus at(std::int64_t) { return {Outcome::solver_stalled, std::nullopt}; }
  /// Writes the vectors at `point`, the state that they have reached.
  virtual void read(const Eigen::MatrixXd& point, Eigen::MatrixXd& V) const = 0;
};

/// What the tangents of a scene depend on: Λ and the step of the map, and their derivatives along
/// each vector, a column of `by_lambda` and a number of `by_h`.
struct TangentParameters {
  Eigen::VectorXd lambda;
  double h = 0;
  Eigen::MatrixXd by_lambda;
  Eigen::VectorXd by_h;

  /// Whether Λ and the step are constant along vector v.
  bool constant(Eigen::Index v) const { return by_lambda.col(v).isZero(0) && by_h(v) == 0; }
};

/// The tangent spaces of a scene's states.
struct TangentSpace {
  /// Returns the tangent part of any G at x, linear in G. x is the state's blocks stacked by rows.
  /// Null for the states (Q, M) of a body, whose coordinates are (η, δM) with δQ = Qη; those of
  /// others belong to an orthonormal basis.
  std::function<Dense(const Dense& x, const Dense& G)> tangent = nullptr;
  /// Where the states there are depend on Λ, so that a state leaves its tangent space when Λ
  /// changes: the same for the states of every Λ together.
  std::function<Dense(const Dense& x, const Dense& G)> tangent_of_every_inertia = nullptr;
  /// And the derivatives by each λ_k of the state that a scene makes of the blocks of x, numbers
  /// column by column in column k.
  std::function<Dense(const Dense& x)> by_inertia = nullptr;
};

/// The tangent of a method's step on a system.
struct MethodTangent {
  std::string_view method;  ///< empty for a discrete system
  std::unique_ptr<TangentMap> (*make)(const Scene&, const TangentParameters&);
  int dimension = 0;  ///< the only N that has it; 0: every one
};

/// Of a view of a body (body_view.h): the derivatives of its blocks x and of y = (Q, M) of the
/// body, along δx or δy and, where they depend on Λ and the step, along δΛ and δh.
struct ViewTangent {
  using Two = std::array<Eigen::MatrixXd, 2>;
  struct Along {
    Eigen::VectorXd lambda;
    double step;
  };
  std::function<Two(const Two& x, const Two& dx, const Along&)> read;  ///< returns δy
  /// Returns δx. x_0 and δx_0 are those at the start, where constants of the motion come from.
  std::function<Two(const Two& x_0, const Two& dx_0, const Two& y, const Two& dy, const Along&)>
      write;
};

/// What gives the tangents of a system's scenes. Those of a view are by the methods of the body.
struct Tangents {
  TangentSpace (*space)(const Scene&);
  std::span<const MethodTangent> methods;
  ViewTangent (*view)(const Scene&) = nullptr;
};

}  // namespace stiefel
