#pragma once

#include <utility>

#include "engine/linalg/iteration/dual_iterations.h"
#include "engine/linalg/lie/so_3.h"
#include "engine/linalg/matrix_equations/dual_equations.h"
#include "engine/methods/support/concepts.h"
#include "engine/methods/support/matrix_system.h"
#include "engine/methods/support/method.h"
#include "engine/stepping/make_simulation_by.h"
#include "engine/stepping/tangent_map.h"
#include "stiefel/scene.h"

namespace stiefel {

/// Converts the states of a map in dual numbers: values from a point, derivatives from a vector of
/// stacked blocks, and back.
template <class Point>
struct TangentCoordinates {
  static Point shape(const Eigen::MatrixXd& point) { return point.cast<Tangent>(); }
  static void set_point(Point& x, const Eigen::MatrixXd& point) { set_values(x, point); }
  static void set_vector(Point& x, int k, const Eigen::VectorXd& v) {
    for (Eigen::Index i = 0; i < x.size(); ++i) x(i).d[k] = v(i);
  }
  static void write(const Point& x, Eigen::MatrixXd& V) {
    for (Eigen::Index i = 0; i < x.size(); ++i)
      for (int k = 0; k < V.cols(); ++k) V(i, k) = x(i).d[k];
  }
};

/// (q; m): δq = ½ q∘(0, η) for δQ = Qη. For a scene without a frame the point is m alone and q = 1.
template <>
struct TangentCoordinates<Eigen::Matrix<Tangent, 7, 1>> {
  using Point = Eigen::Matrix<Tangent, 7, 1>;

  static Point shape(const Eigen::MatrixXd&) { return Point::Zero(); }
  static void set_point(Point& x, const Eigen::MatrixXd& point) {
    const Eigen::Index above = 7 - point.size();
    x(0).value = 1;
    for (Eigen::Index i = above; i < 7; ++i) x(i).value = point(i - above);
  }
  static void set_vector(Point& x, int k, const Eigen::VectorXd& v) {
    const Eigen::Index rows = v.size() / 3;
    const Eigen::Map<const Eigen::MatrixXd> blocks(v.data(), rows, 3);
    const Eigen::Vector3d m = vee(blocks.bottomRows(3));
    for (int i = 0; i < 3; ++i) x(4 + i).d[k] = m(i);
    if (rows == 3) return;
    const Eigen::Matrix<double, 7, 1> values = values_of(x);
    const Eigen::Matrix3d Qt_dQ =
        rotation_matrix<double>(values.head<4>()).transpose() * blocks.topRows(3);
    const Eigen::Vector3d eta = vee(((Qt_dQ - Qt_dQ.transpose()) / 2).eval());
    const Eigen::Vector4d dq = So3<double, true>::quaternion_times(values, (eta / 2).eval());
    for (int i = 0; i < 4; ++i) x(i).d[k] = dq(i);
  }
  static void write(const Point& x, Eigen::MatrixXd& V) {
    const Eigen::Index rows = V.rows() / 3;
    Matrix<Tangent> blocks(rows, 3);
    blocks.bottomRows(3) = hat(x.tail<3>());
    if (rows == 6) blocks.topRows(3) = rotation_matrix<Tangent>(x.head<4>());
    for (Eigen::Index i = 0; i < blocks.size(); ++i)
      for (int k = 0; k < V.cols(); ++k) V(i, k) = blocks(i).d[k];
  }
};

/// The TangentMap of a Map in dual numbers. At every step the values of its state are those of the
/// simulation; the derivatives, and what compensated arithmetic carries for them, stay.
template <class F>
requires Map<F>
class TangentMapOf final : public TangentMap {
 public:
  /// `make()` returns the map, which is not moved: its workspace has no values yet.
  template <class Make>
  TangentMapOf(const Make& make, int substeps) : map_(make()), substeps_(substeps) {}

  void start(const Eigen::MatrixXd& point, const Eigen::MatrixXd& V) override {
    Point x = Coordinates_::shape(point);
    Coordinates_::set_point(x, point);
    for (int k = 0; k < V.cols(); ++k) Coordinates_::set_vector(x, k, V.col(k));
    state_.emplace(map_.start(x));
  }

  RunStatus step(const Eigen::MatrixXd& point) override {
    auto& x = state_->x;
    if constexpr (has_inner_state) {
      Coordinates_::set_point(x.value, point);
      state_.emplace(map_.start(Point(x.value)));
    } else {
      Coordinates_::set_point(x.value, point);
      if (x.compensated)
        for (Eigen::Index i = 0; i < x.carry.size(); ++i) x.carry(i).value = 0;
    }
    for (int k = 0; k < substeps_; ++k)
      if (const RunStatus status = map_.step(*state_); !status.reached()) return status;
    return {};
  }

  bool direct() const override { return DirectMap<F>; }
  RunStatus at(std::int64_t k) override {
    if constexpr (DirectMap<F>) {
      const auto steps = static_cast<long double>(k) * substeps_;
      return map_.at(*state_, steps);
    } else {
      return {Outcome::solver_stalled, std::nullopt};
    }
  }

  void read(const Eigen::MatrixXd& point, Eigen::MatrixXd& V) const override {
    Point x = state_->x.value;
    Coordinates_::set_point(x, point);
    Coordinates_::write(x, V);
  }

 private:
  using Point = typename F::Point;
  using Coordinates_ = TangentCoordinates<Point>;
  static constexpr bool has_left = requires(typename F::State s) { s.left; };
  static constexpr bool has_symmetric = requires(typename F::State s) { s.symmetric; };
  static constexpr bool has_M = requires(typename F::State s) { s.M; };
  /// Whether the map moves other variables than the system's, which start from the values anew.
  static constexpr bool has_inner_state = has_left || has_symmetric || has_M;

  F map_;
  int substeps_;
  std::optional<typename F::State> state_;
};

/// Returns the tangents of `system` by Method, as the scene chooses it.
template <class Method, class S>
std::unique_ptr<TangentMap> make_tangent_by(const Scene& scene, const S& system, const Tangent& h) {
  using Moved = typename MovedOf<typename Method::template Map<S>>::type;
  const int order = scene.order() > 0 ? scene.order() : Method::traits.default_order;
  const MethodOptions options(order, scene.arithmetic(), scene.tolerance());
  return std::make_unique<TangentMapOf<Moved>>(
      [&] { return typename Method::template Map<S>(system, h, options); }, scene.substeps());
}

/// The tangents by a method of systems whose states are matrices of any size, known by the vector
/// field or by the action of a group; both null where the method has none for such systems.
struct GeneralTangents {
  template <class System>
  using Make = std::unique_ptr<TangentMap> (*)(const Scene&, const System&, const Tangent& h);
  Make<MatrixSystem<Tangent>> by_field = nullptr;
  Make<MatrixLieSystem<Tangent>> by_action = nullptr;
};
GeneralTangents general_tangents(std::string_view method);

/// Returns the tangents of `system` by a general method; null if the method has none for it.
template <HasMatrixStates S>
std::unique_ptr<TangentMap> make_general_tangent(const Scene& scene, const S& system,
                                                 const Tangent& h) {
  const GeneralTangents general = general_tangents(scene.method());
  if (general.by_field) return general.by_field(scene, system, h);
  if constexpr (LieSystem<S>)
    if (general.by_action) return general.by_action(scene, system, h);
  return nullptr;
}

/// Returns the tangents of `system` by the scene's method; null if it has none.
template <HasMatrixStates S>
std::unique_ptr<TangentMap> make_tangent(const Scene& scene, const S& system, const Tangent& h) {
  std::unique_ptr<TangentMap> made;
  for_each_type(typename SpecialMethods<S>::type{}, [&]<class Method>(Method*) {
    if (scene.method() == Method::traits.name) made = make_tangent_by<Method>(scene, system, h);
  });
  return made ? std::move(made) : make_general_tangent(scene, system, h);
}

}  // namespace stiefel
