// What is read of the states of rigid bodies.
#include <algorithm>

#include "engine/body/reports_3.h"
#include "engine/body/rigid_forms.h"
#include "engine/dense/so_3.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

/// Reports a body in three dimensions in the caller's axes.
class Observables3 final : public Observables {
 public:
  explicit Observables3(const Scene& scene) : body_(body_3(scene)), reports_(scene) {
    fields_ = reports_.fields();
    block_count_ = reports_.block_count();
  }

  Point start(const Scene&) const override { return point(body_.attitude, body_.m); }
  void write(const Point& x, std::size_t index, std::span<double> out) const override {
    reports_.write(body_, x.data(), index, out);
  }
  void invariants(const Point& x, InvariantList& out) const override {
    reports_.invariants(body_, x.data(), out);
  }
  std::optional<double> orthogonality(const Point& x) const override {
    return reports_.orthogonality(body_, x.data());
  }
  double rate(const Point& x) const override { return reports_.rate(body_, x.data()); }

  Point from_blocks(const Dense& blocks) const override {
    return point(body_.has_frame ? quaternion_of(body_.determinant * blocks.topRows(3))
                                 : Eigen::Vector4d::UnitX(),
                 vee(blocks.bottomRows(3)));
  }
  Dense to_blocks(const Point& x) const override {
    Dense out(body_.has_frame ? 6 : 3, 3);
    if (body_.has_frame)
      out.topRows(3) = body_.determinant * rotation_matrix<double>(Eigen::Vector4d(x.topRows<4>()));
    out.bottomRows(3) = hat(Eigen::Vector3d(x.bottomRows<3>()));
    return out;
  }

 private:
  Point point(const Eigen::Vector4d& q, const Eigen::Vector3d& m) const {
    Point x(reports_.size(), 1);
    if (body_.has_frame) x.topRows<4>() = q;
    x.bottomRows<3>() = m;
    return x;
  }

  Reported3 body_;
  Reports3 reports_;
};

/// Returns the observables of states Q over M, or M alone, in N dimensions.
StackedObservables observables_of_matrices(const Scene& scene) {
  const int N = scene.dimension(), top = static_cast<int>(scene.Q().rows());
  Dense start(top + N, N);
  if (top > 0) start.topRows(top) = scene.Q();
  start.bottomRows(N) = body_momentum(scene);
  StackedObservables observables(start);
  if (top > 0) observables.block("Q", 0, N);
  observables.block("M", top, N);
  const RigidForm form = {.Q = [top](const auto& x) -> Dense { return x.topRows(top); },
                          .M = [N](const auto& x) -> Dense { return x.bottomRows(N); }};
  report_rigid_fields(observables, scene, form);
  report_rigid_invariants(observables, scene, form);
  return observables;
}

/// Reads the points of a rigid body as the blocks of a view; all else is read from Q over M. At
/// step 0 the blocks are the scene's own.
class ViewedBody final : public StackedObservables {
 public:
  ViewedBody(const Scene& scene, SharedObservables body, const SystemEntry& entry)
      : StackedObservables(stacked(blocks_of_view(scene))),
        body_(std::move(body)),
        view_(entry.view(scene)),
        given_(StackedObservables::start(scene)),
        start_(from_blocks(given_)),
        right_(entry.info.side == Side::right) {
    const int N = scene.dimension();
    for (const int i : {0, 1}) block(std::string(entry.info.blocks[i].name), i * N, N);
    const RigidForm form = {
        .Q = [right = right_, N](const auto& x) -> Dense {
          if (right) return x.topRows(N).transpose();
          return x.topRows(N);
        },
        .M = [sign = right_ ? -1 : 1, N](const auto& x) -> Dense { return sign * x.bottomRows(N); },
        .side = entry.info.side,
        .scaled = std::ranges::find(entry.info.fields, "epsilon", &FieldInfo::name) !=
                  entry.info.fields.end()};
    report_rigid_fields(*this, scene, form);
    report_rigid_invariants(*this, scene, form);
  }

  Point start(const Scene&) const override { return start_; }
  void write(const Point& x, std::size_t index, std::span<double> out) const override {
    StackedObservables::write(index < block_count_ ? to_blocks(x) : body_->to_blocks(x), index,
                              out);
  }
  void invariants(const Point& x, InvariantList& out) const override {
    if (right_)
      StackedObservables::invariants(body_->to_blocks(x), out);
    else
      body_->invariants(x, out);
  }
  std::optional<double> orthogonality(const Point& x) const override {
    return StackedObservables::orthogonality(body_->to_blocks(x));
  }
  double rate(const Point& x) const override { return body_->rate(x); }
  Point from_blocks(const Dense& blocks) const override {
    return body_->from_blocks(stacked(view_.body(halves(blocks))));
  }
  Dense to_blocks(const Point& x) const override {
    return x == start_ ? given_ : stacked(view_.blocks(halves(body_->to_blocks(x))));
  }

 private:
  static Dense stacked(const BodyView::Two& blocks) {
    Dense x(2 * blocks[0].rows(), blocks[0].cols());
    x << blocks[0], blocks[1];
    return x;
  }
  static BodyView::Two halves(const Dense& x) {
    return {x.topRows(x.cols()), x.bottomRows(x.cols())};
  }

  SharedObservables body_;
  BodyView view_;
  Dense given_;
  Point start_;
  bool right_;
};

}  // namespace

SharedObservables rigid_body_observables(const Scene& scene) {
  SharedObservables body =
      scene.dimension() == 3 ? shared(Observables3(scene)) : shared(observables_of_matrices(scene));
  const SystemEntry& entry = *system_entry(scene.system());
  return entry.view ? shared(ViewedBody(scene, std::move(body), entry)) : body;
}

}  // namespace stiefel
