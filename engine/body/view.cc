#include "engine/body/view.h"

#include <algorithm>

#include "engine/body/rigid_forms.h"
#include "engine/motion/system_entry.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

bool has_epsilon(const SystemInfo& system) {
  return std::ranges::find(system.fields, "epsilon", &FieldInfo::name) != system.fields.end();
}

/// Reads the points of a rigid body as the blocks of a view. At step 0 these are the scene's own.
class ViewedBody final : public Observables {
 public:
  ViewedBody(const Scene& scene, SharedObservables body, BodyView view)
      : body_(std::move(body)),
        view_(std::move(view)),
        given_(blocks_of_view(scene)),
        start_(body_->from_blocks(view_.body(given_))),
        right_(system_entry(scene.system())->info.side == Side::right),
        form_(given_) {
    const int N = scene.dimension();
    for (const int i : {0, 1})
      form_.block(std::string(system_entry(scene.system())->info.blocks[i].name), i * N, N);
    report_rigid_form(form_, scene,
                      {.Q = [right = right_, N](const auto& x) -> Dense {
                         if (right) return x.topRows(N).transpose();
                         return x.topRows(N);
                       },
                       .M = [sign = right_ ? -1 : 1, N](const auto& x) -> Dense {
                         return sign * x.bottomRows(N);
                       },
                       .side = system_entry(scene.system())->info.side,
                       .scaled = has_epsilon(system_entry(scene.system())->info)});
    fields_ = form_.fields();
    block_count_ = form_.block_count();
  }

  Point start(const Scene&) const override { return start_; }
  void write(const Point& x, std::size_t index, std::span<double> out) const override {
    form_.write(index < block_count_ ? to_blocks(x) : body_->to_blocks(x), index, out);
  }
  void invariants(const Point& x, InvariantList& out) const override {
    if (right_)
      form_.invariants(body_->to_blocks(x), out);
    else
      body_->invariants(x, out);
  }
  std::optional<double> orthogonality(const Point& x) const override {
    return form_.orthogonality(body_->to_blocks(x));
  }
  double rate(const Point& x) const override { return body_->rate(x); }
  Point from_blocks(const Dense& blocks) const override {
    return body_->from_blocks(view_.body(blocks));
  }
  Dense to_blocks(const Point& x) const override {
    return x == start_ ? given_ : view_.blocks(body_->to_blocks(x));
  }

 private:
  SharedObservables body_;
  BodyView view_;
  Dense given_;
  Point start_;
  bool right_;
  StackedObservables form_;  ///< reads the blocks of the view, and all else from Q over M
};

}  // namespace

SharedObservables viewed(const Scene& scene, SharedObservables body) {
  return shared(ViewedBody(scene, std::move(body), system_entry(scene.system())->view(scene)));
}

}  // namespace stiefel
