#include "engine/body/exact_body.h"

#include <algorithm>

#include "engine/body/rigid_forms.h"
#include "engine/methods/exact.h"
#include "engine/motion/simulation_of.h"
#include "engine/scene/given_body.h"

namespace stiefel {
namespace {

using Point = Observables::Point;

/// The motion of a body in three dimensions. A state is its point: (q; m), or m alone.
class ExactBody final : public ClosedForm<Point> {
 public:
  explicit ExactBody(TopInTime top) : top_(std::move(top)) {}

  bool at(Wide k, double h, Point& x) override { return take(top_.at(k, h), x); }
  bool at(std::span<const double> times, Point& x) override { return take(top_.at(times), x); }

 private:
  static bool take(const TopInTime::Point& found, Point& x) {
    if (!found.allFinite()) return false;
    std::copy_n(found.data() + found.size() - x.size(), x.size(), x.data());
    return true;
  }

  TopInTime top_;
};

}  // namespace

bool is_exact_body(const Scene& scene) {
  return scene.dimension() == 3 && scene.method() == method_name::exact;
}

std::unique_ptr<Simulation> exact_body(const Scene& scene) {
  const Eigen::Vector3d lambda = scene.inertia();
  const auto motion = [lambda, given = extended_body(scene)](const Point& start) {
    const std::span state(start.data(), static_cast<std::size_t>(start.size()));
    return std::make_shared<ExactBody>(top_in_time(lambda, given, state));
  };
  using Map = ClosedFormMap<Point>;
  return std::make_unique<SimulationOf<Map>>(scene, Map(motion, scene.step() / scene.substeps()),
                                             rigid_body_observables(scene));
}

TopInTime top_in_time(const Eigen::Vector3d& lambda, const std::optional<ExtendedBody>& given,
                      std::span<const double> state) {
  TopInTime::WidePoint x;
  x << 1, 0, 0, 0, 0, 0, 0;
  std::ranges::copy(state, x.data() + x.size() - state.size());
  if (!given) return {PrincipalMoments3<Number128>(lambda), x};
  return {PrincipalMoments3<Number128>(given->inertia.moments.cast<Number128>(),
                                       given->inertia.differences.cast<Number128>()),
          x, given->axes, given->momentum_tail};
}

}  // namespace stiefel
