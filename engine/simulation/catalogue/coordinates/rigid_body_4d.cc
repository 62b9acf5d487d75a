#include "engine/simulation/catalogue/coordinates/rigid_body_4d.h"

#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/families/rigid_body_observables.h"
#include "engine/simulation/stepping/simulate.h"
#include "engine/simulation/stepping/stored_as.h"

namespace stiefel {
namespace {

using MethodsInSo4 = MethodsThat<&MethodTraits::in_so4>;

/// The coordinates of So4 as a form for StoredAs.
template <class Scalar, bool frame>
struct Coordinates {
  using Space = So4<Scalar, frame>;
  using Wide = Eigen::MatrixXd;  ///< Q over M
  using Point = typename Space::State;

  static Point to_stored(const Wide& x) {
    Eigen::Matrix<double, Point::RowsAtCompileTime, 1> out;
    if constexpr (frame) out.template head<16>() = x.topRows(4).reshaped();
    for (int k = 0; k < 6; ++k)
      out(Space::first + k) = x(x.rows() - 4 + skew4_rows[k], skew4_columns[k]);
    return rounded_to<Scalar>(out);
  }
  static Wide to_wide(const Point& x) {
    Wide out = Wide::Zero(frame ? 8 : 4, 4);
    if constexpr (frame) out.topRows(4).reshaped() = x.template head<16>().template cast<double>();
    for (int k = 0; k < 6; ++k) {
      const int i = skew4_rows[k], j = skew4_columns[k], top = frame ? 4 : 0;
      out(top + i, j) = x(Space::first + k);
      out(top + j, i) = -x(Space::first + k);
    }
    return out;
  }
};

template <class Scalar, bool frame>
auto observables(const Scene& scene) {
  using Observables = RigidBodyObservables<SoN<double>>;
  return StoredAs<Coordinates<Scalar, frame>, Observables>(Observables(scene));
}

template <class Scalar, bool frame>
std::unique_ptr<Simulation> body(const Scene& scene) {
  return simulate<MethodsInSo4>(scene,
                                RigidBody<So4<Scalar, frame>>(rounded_to<Scalar>(scene.inertia())),
                                observables<Scalar, frame>(scene), rigid_body_cost(4));
}

template <bool frame>
std::unique_ptr<Simulation> discrete_body(const Scene& scene) {
  using Map = MoserVeselov<So4<double, frame>, Arithmetic::compensated>;
  return simulate_map(scene, Map(scene.inertia(), scene.step()), observables<double, frame>(scene),
                      rigid_body_cost(4));
}

}  // namespace

bool is_rigid_body_4d(const Scene& scene) {
  if (scene.dimension() != 4) return false;
  bool moved = scene.method().empty();
  for_each_type(MethodsInSo4{}, [&]<class Method>(Method*) {
    moved = moved || scene.method() == Method::traits.name;
  });
  return moved;
}

std::unique_ptr<Simulation> rigid_body_4d(const Scene& scene) {
  if (scene.in_float())
    return scene.has_frame() ? body<float, true>(scene) : body<float, false>(scene);
  return scene.has_frame() ? body<double, true>(scene) : body<double, false>(scene);
}

std::unique_ptr<Simulation> moser_veselov_4d(const Scene& scene) {
  return scene.has_frame() ? discrete_body<true>(scene) : discrete_body<false>(scene);
}

}  // namespace stiefel
