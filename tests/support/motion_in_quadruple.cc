#include "tests/support/motion_in_quadruple.h"

#include <memory>

#include "engine/accuracy/series_equations.h"
#include "engine/body/rigid_body_data.h"
#include "engine/bracket/taylor_double_bracket.h"
#include "engine/dense/taylor_rigid_body.h"
#include "engine/frame/stiefel_forms.h"
#include "engine/frame/taylor_stiefel.h"
#include "engine/motion/system_entry.h"
#include "tests/support/linalg/quadruple.h"

namespace stiefel::testing {
namespace {

constexpr double largest_error = 1e-30;

template <class Series>
std::function<MotionState(double)> motion(Series series, const SeriesStart<Quad>& start) {
  const Eigen::Index momentum_rows = series.momentum_rows();
  const auto made =
      std::make_shared<TaylorMotion<Series>>(std::move(series), start.x, largest_error);
  return [=, as = start.reported](double t) {
    if (!made->go_to(t, [] { return false; })) throw std::runtime_error("the motion ends");
    return present(as, made->state(), momentum_rows);
  };
}

}  // namespace

std::function<MotionState(double)> motion_in_quadruple(const Scene& scene) {
  const MotionStart& motion_of = *system_entry(scene.system())->motion;
  const auto start = motion_of.quadruple(scene);
  const int order = taylor_order(largest_error);
  if (motion_of.equations == &body_equations)
    return motion(TaylorRigidBody<Quad>(start.lambda, order), start);
  if (motion_of.equations == &parametric_equations)
    return motion(TaylorRigidBody<Quad, true>(start.lambda, start.mu, order), start);
  if (motion_of.equations == &frame_equations)
    return motion(TaylorStiefel<Quad>(start.lambda, start.x.rows() / 2, order), start);
  if (motion_of.equations == &double_bracket_equations)
    return motion(TaylorDoubleBracket<Quad>(start.lambda, start.lambda_v, order), start);
  return {};
}

}  // namespace stiefel::testing
