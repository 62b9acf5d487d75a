// What is read of the states of rigid bodies.
#include <algorithm>

#include "engine/body/reports_3.h"
#include "engine/body/rigid_forms.h"
#include "engine/dense/so_3.h"

namespace stiefel {
namespace {

using Point = Observables::Point;

/// Reports a body in three dimensions in the caller's axes.
Observables observables_3(const Scene& scene) {
  struct Reported {
    explicit Reported(const Scene& like) : body(body_3(like)), reports(like) {}
    Point point(const Eigen::Vector4d& q, const Eigen::Vector3d& m) const {
      Point x(reports.size(), 1);
      if (body.has_frame) x.topRows<4>() = q;
      x.bottomRows<3>() = m;
      return x;
    }
    Reported3 body;
    Reports3 reports;
  };
  const auto held = std::make_shared<const Reported>(scene);
  const Reported* of = held.get();  // of which small functions need no memory of their own
  Observables out(of->point(of->body.attitude, of->body.m));
  for (std::size_t i = 0; i < of->reports.fields().size(); ++i) {
    const auto value = [of, i](const Point& x, Eigen::Ref<RowMatrix> to) {
      of->reports.write(of->body, x.data(), i, {to.data(), static_cast<std::size_t>(to.size())});
    };
    const Field& field = of->reports.fields()[i];
    i < of->reports.block_count() ? out.computed_block(field, value) : out.field(field, value);
  }
  out.all_invariants = [of, held](const Point& x, InvariantList& list) {
    of->reports.invariants(of->body, x.data(), list);
  };
  out.frame_defect = [of](const Point& x) { return of->reports.orthogonality(of->body, x.data()); };
  out.speed = [of](const Point& x) { return of->reports.rate(of->body, x.data()); };
  out.from_blocks = [of](const Dense& blocks) {
    return of->point(of->body.has_frame ? quaternion_of(of->body.determinant * blocks.topRows(3))
                                        : Eigen::Vector4d::UnitX(),
                     vee(blocks.bottomRows(3)));
  };
  out.to_blocks = [of](const Point& x) {
    Dense blocks(of->body.has_frame ? 6 : 3, 3);
    if (of->body.has_frame)
      blocks.topRows(3) =
          of->body.determinant * rotation_matrix<double>(Eigen::Vector4d(x.topRows<4>()));
    blocks.bottomRows(3) = hat(Eigen::Vector3d(x.bottomRows<3>()));
    return blocks;
  };
  return out;
}

/// Returns the observables of states Q over M, or M alone, in N dimensions.
Observables observables_of_matrices(const Scene& scene) {
  const int N = scene.dimension(), top = static_cast<int>(scene.Q().rows());
  Dense start(top + N, N);
  if (top > 0) start.topRows(top) = scene.Q();
  start.bottomRows(N) = body_momentum(scene);
  Observables observables(start);
  if (top > 0) observables.block("Q", 0, N);
  observables.block("M", top, N);
  const RigidForm form = {.Q = [top](const auto& x) -> Dense { return x.topRows(top); },
                          .M = [N](const auto& x) -> Dense { return x.bottomRows(N); }};
  report_rigid_form(observables, scene, form);
  return observables;
}

Dense stacked(const BodyView::Two& blocks) {
  Dense x(2 * blocks[0].rows(), blocks[0].cols());
  x << blocks[0], blocks[1];
  return x;
}
BodyView::Two halves(const Dense& x) { return {x.topRows(x.cols()), x.bottomRows(x.cols())}; }

/// Reads the points of a rigid body as the blocks of a view; all else is read from Q over M. At
/// step 0 the blocks are the scene's own.
Observables view_of(const Scene& scene, const SharedObservables& body, const SystemEntry& entry) {
  const int N = scene.dimension();
  const bool right = entry.info.side == Side::right;
  const BodyView view = entry.view(scene);
  const BodyView::Two given = blocks_of_view(scene);
  Observables out(body->from_blocks(stacked(view.body(given))));
  out.from_blocks = [=](const Dense& blocks) {
    return body->from_blocks(stacked(view.body(halves(blocks))));
  };
  // One function for all, because it holds the blocks and the point at step 0.
  const auto to_blocks = std::make_shared<const std::function<Dense(const Point&)>>(
      [=, start = out.start](const Point& x) {
        return stacked(x == start ? given : view.blocks(halves(body->to_blocks(x))));
      });
  out.to_blocks = [to_blocks](const Point& x) { return (*to_blocks)(x); };
  for (const int i : {0, 1})
    out.computed_block({std::string(entry.info.blocks[i].name), N, N},
                       [=](const Point& x, Eigen::Ref<RowMatrix> to) {
                         to = (*to_blocks)(x).middleRows(i * N, N);
                       });
  const RigidForm form = {.Q = [=](const Point& x) -> Dense {
                            const Dense Q = body->to_blocks(x).topRows(N);
                            if (right) return Q.transpose();
                            return Q;
                          },
                          .M = [=](const Point& x) -> Dense {
                            return (right ? -1 : 1) * body->to_blocks(x).bottomRows(N);
                          },
                          .side = entry.info.side,
                          .scaled = std::ranges::find(entry.info.fields, "epsilon",
                                                      &FieldInfo::name) != entry.info.fields.end()};
  report_rigid_form(out, scene, form);
  if (!right) out.all_invariants = body->all_invariants;
  out.speed = body->speed;
  return out;
}

}  // namespace

SharedObservables rigid_body_observables(const Scene& scene) {
  SharedObservables body =
      shared(scene.dimension() == 3 ? observables_3(scene) : observables_of_matrices(scene));
  const SystemEntry& entry = *system_entry(scene.system());
  return entry.view ? shared(view_of(scene, body, entry)) : body;
}

}  // namespace stiefel
