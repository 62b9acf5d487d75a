// What is read of the states of rigid bodies.
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/body/rigid_forms.h"
#include "engine/dense/orthogonal.h"
#include "engine/dense/so_3.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

/// A body in three dimensions; a point is (q; m) or m alone, along the principal axes.
struct Body3 {
  explicit Body3(const Scene& scene)
      : lambda(scene.inertia()), frame(scene.has_frame()), determinant(scene.determinant()) {
    if (scene.method().empty()) map_step = scene.step();
    if (!scene.axes()) return;
    R = scene.axes()->rotation;
    r_conjugate = quaternion_of(*R);
    r_conjugate.tail<3>() *= -1;
  }

  static Eigen::Vector3d m(const Dense& x) { return x.bottomRows<3>(); }
  static Eigen::Vector4d q(const Dense& x) { return x.topRows<4>(); }
  /// Q of a point; empty where the scene has none.
  Dense Q(const Dense& x) const {
    return frame ? Dense(determinant * rotation_matrix<double>(q(x))) : Dense(0, 0);
  }
  Eigen::Vector3d omega(const Dense& x) const {
    Eigen::Vector3d w;
    So3<double, false>::inverse_inertia(lambda, m(x), w);
    return w;
  }
  Dense point(const Eigen::Vector4d& q, const Eigen::Vector3d& m) const {
    Dense x(frame ? 7 : 3, 1);
    if (frame) x.topRows<4>() = q;
    x.bottomRows<3>() = m;
    return x;
  }

  Eigen::Vector3d to_caller(const Eigen::Vector3d& v) const { return R ? *R * v : v; }
  /// The vector of Q A Qᵀ in space axes for A = hat(v) in principal axes. A number that overflows
  /// is the largest one, so that a state counts as finite as long as q and v are.
  static Eigen::Vector3d to_space(const Dense& x, const Eigen::Vector3d& v) {
    constexpr double most = std::numeric_limits<double>::max();
    return Eigen::Vector3d(rotation_matrix<double>(q(x)) * v).unaryExpr([](double y) {
      return std::isfinite(y) ? y : std::copysign(most, y);
    });
  }

  Eigen::Vector3d lambda;
  bool frame;
  double determinant;
  std::optional<double> map_step;  ///< the step of the discrete body
  std::optional<Eigen::Matrix3d> R;
  Eigen::Vector4d r_conjugate = Eigen::Vector4d::UnitX();
};

/// Reports a body in three dimensions in the caller's axes.
class Observables3 final : public StackedObservables {
 public:
  explicit Observables3(const Scene& scene)
      : Observables3(scene, std::make_unique<const Body3>(scene)) {}

  Point from_blocks(const Dense& blocks) const override {
    return body_->point(body_->frame ? quaternion_of(body_->determinant * blocks.topRows(3))
                                     : Eigen::Vector4d::UnitX(),
                        vee(blocks.bottomRows(3)));
  }
  Dense to_blocks(const Point& x) const override {
    const Dense Q = body_->Q(x);
    Dense out(Q.rows() + 3, 3);
    out << Q, hat(body_->m(x));
    return out;
  }

  void invariants(const Point& x, InvariantList& out) const override {
    const Dense M = hat(body_->m(x));
    rigid_body_invariants(Side::left, body_->lambda, body_->Q(x), M, out);
    if (body_->map_step) add_discrete_hamiltonian(body_->lambda, M, *body_->map_step, out);
  }
  std::optional<double> orthogonality(const Point& x) const override {
    if (!body_->frame) return std::nullopt;
    return orthogonality_defect(body_->Q(x));
  }
  double rate(const Point& x) const override { return body_->omega(x).norm(); }

 private:
  using Square = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

  Observables3(const Scene& scene, std::unique_ptr<const Body3> held)
      : StackedObservables(
            held->point(held->frame ? scene.attitude() : Eigen::Vector4d(Eigen::Vector4d::UnitX()),
                        vee(body_momentum(scene)))),
        body_(std::move(held)) {
    const Body3* const body = body_.get();  // a copy in each function would take kilobytes
    if (body->frame)
      computed_block({"Q", 3, 3}, [body](const auto& x, auto out) {
        Square Q = body->Q(x);
        if (body->R) Q *= body->R->transpose();
        Eigen::Map<Square>(out.data()) = Q;
      });
    computed_block({"M", 3, 3}, [body](const auto& x, auto out) {
      Eigen::Map<Square>(out.data()) = hat(body->to_caller(body->m(x)));
    });
    field({"Omega", 3, 3}, [body](const auto& x, auto out) {
      Eigen::Map<Square>(out.data()) = hat(body->to_caller(body->omega(x)));
    });
    if (body->frame && scene.determinant() == 1)
      field({"quaternion", 1, 4}, [body](const auto& x, auto out) {
        const Eigen::Vector4d q = body->q(x), &r = body->r_conjugate;
        Eigen::Map<Eigen::Vector4d>(out.data()) =
            body->R ? So3<double, true>::quaternion_times(q, r(0), r.tail<3>()) : q;
      });
    field({"angular_velocity", 1, 3}, [body](const auto& x, auto out) {
      Eigen::Map<Eigen::Vector3d>(out.data()) = body->to_caller(body->omega(x));
    });
    if (body->frame) {
      field({"angular_velocity_space", 1, 3}, [body](const auto& x, auto out) {
        Eigen::Map<Eigen::Vector3d>(out.data()) = body->to_space(x, body->omega(x));
      });
      field({"momentum_space", 1, 3}, [body](const auto& x, auto out) {
        Eigen::Map<Eigen::Vector3d>(out.data()) = body->to_space(x, body->m(x));
      });
    }
  }

  std::unique_ptr<const Body3> body_;
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
