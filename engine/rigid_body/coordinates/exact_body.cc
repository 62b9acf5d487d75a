#include "engine/rigid_body/coordinates/body_by_method.h"

#include "engine/methods/exact.h"
#include "engine/rigid_body/exact/euler_top.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_body_observables.h"
#include "engine/scene/given_body.h"
#include "engine/stepping/make_simulation_by.h"

namespace stiefel {
namespace {

using Space = So3<double, true>;
using Wide = ExtendedBody::Wide;
using WidePoint = So3<Wide, true>::State;
using Quaternion = Eigen::Matrix<Wide, 4, 1>;

/// The system that Exact moves, with states (q; m) in the axes of the scene.
struct BodyAsGiven {
  using Scalar = double;
  using State = Space::State;
  ExtendedBody body;
};

Quaternion product(const Quaternion& a, const Quaternion& b) {
  return So3<Wide, true>::quaternion_times(a, b(0), b.tail<3>());
}
Quaternion conjugate(const Quaternion& q) { return {q(0), -q(1), -q(2), -q(3)}; }

/// Returns (q; m) in the axes of x turned by r, which are the vectors r e_i r*: (q∘r; r* m r).
WidePoint in_axes_turned_by(const Quaternion& r, const WidePoint& x) {
  WidePoint y;
  y << product(x.head<4>(), r), rotation_matrix<Wide>(r).transpose() * x.tail<3>();
  return y;
}

/// Computes the motion along the body's own axes, and returns it in the scene's axes.
class TopInScene {
 public:
  TopInScene(const ExtendedBody& body, WidePoint start) : to_scene_(conjugate(body.axes)) {
    start.tail<3>() += body.momentum_tail;
    motion_.emplace(body.inertia, in_axes_turned_by(body.axes, start));
  }
  WidePoint at(Wide t) const { return in_axes_turned_by(to_scene_, motion_->at(t)); }

 private:
  Quaternion to_scene_;
  std::optional<EulerTop<Wide, true>> motion_;
};

}  // namespace

template <>
struct Exact::MotionOf<BodyAsGiven> {
  static TopInScene make(const BodyAsGiven& system, const BodyAsGiven::State& start) {
    return {system.body, start.cast<Wide>()};
  }
};

bool is_exact_body(const Scene& scene) {
  return scene.axes() && scene.method() == Exact::traits.name;
}

std::unique_ptr<Simulation> exact_body(const Scene& scene) {
  return make_simulation_by<Exact>(scene, BodyAsGiven{*extended_body(scene)},
                                   rigid_body_observables(scene));
}

}  // namespace stiefel
