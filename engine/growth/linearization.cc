#include "stiefel/linearization.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/dense/so_3.h"
#include "engine/growth/coordinates.h"
#include "engine/motion/observed_simulation.h"
#include "engine/numbers/to_text.h"
#include "engine/scene/scene_draft.h"
#include "stiefel/price.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

constexpr double tangency = 1e-8;

/// Returns the point, in principal axes. A scene without members has no other simulation.
const Dense& point_of(const Simulation& motion) {
  return dynamic_cast<const ObservedSimulation&>(motion).point();
}

/// The vectors and the map that moves them.
class MovedVectors final : public Linearization {
 public:
  /// Takes the vectors V at the state x of `start`, in the caller's axes; adds those of parameters.
  MovedVectors(const Scene& scene, const LinearizationDescription& what, TangentChart chart,
               const Dense& x, const Dense& V, const Simulation& start)
      : scene_(scene),
        as_blocks_(what.as_blocks),
        by_inertia_(what.by_inertia),
        first_(start.step()),
        chart_(std::move(chart)) {
    rows_ = chart_.rows();
    cols_ = chart_.cols();
    const Eigen::VectorXd& lambda = scene.inertia();
    const Eigen::Index given = V.cols(), inertia = what.by_inertia ? lambda.size() : 0;
    count_ = given + inertia + (what.by_step ? 1 : 0);
    TangentParameters at{lambda, scene.description().step.value_or(0) / scene.substeps(),
                         Dense::Zero(lambda.size(), count_), Eigen::VectorXd::Zero(count_)};
    at.by_lambda.middleCols(given, inertia).setIdentity();
    at.by_h.tail(count_ - given - inertia).setConstant(1.0 / scene.substeps());
    const Dense by_inertia =
        by_inertia_ && chart_.space().by_inertia ? chart_.space().by_inertia(x) : Dense();
    if (const auto view = tangents_of(scene.system())->view) {
      view_ = view(scene);
      start_ = x;
      start_vectors_.resize(chart_.size(), count_);
      parameters_ = at;
    }
    Dense all(chart_.size(), count_);
    for (Eigen::Index v = 0; v < count_; ++v) {
      stop_point();
      if (v < given)
        all.col(v) = V.col(v);
      else if (v - given < by_inertia.cols())
        all.col(v) = by_inertia.col(v - given);
      else
        all.col(v).setZero();
      if (!view_) continue;
      start_vectors_.col(v) = all.col(v);
      stop_point(products_of_view());
      put(view_->read(halves(x), halves(all.col(v)), along(v)), all.col(v));
    }
    turn(false, all);
    map_ = tangent_of(scene, scene.method())->make(scene, at);
    map_->start(point_of(start), all);
  }

  RunStatus advance(Simulation& motion, std::int64_t steps, const std::stop_token& stop) override {
    if (map_->direct()) {
      const RunStatus status = motion.advance(steps, stop);
      if (!status.reached()) return status;
      return unless_stopped(stop, [&] { return map_->at(motion.step() - first_); })
          .value_or(RunStatus{Outcome::cancelled, std::nullopt});
    }
    for (; steps > 0; --steps) {
      point_ = point_of(motion);
      if (const RunStatus status = motion.advance(1, stop); !status.reached()) return status;
      const RunStatus status = unless_stopped(stop, [&] {
                                 return map_->step(point_);
                               }).value_or(RunStatus{Outcome::cancelled, std::nullopt});
      if (!status.reached()) return status;
    }
    return {};
  }

  Dense vectors(const Simulation& motion) const override {
    Dense V(chart_.size(), count_);
    map_->read(point_of(motion), V);
    turn(true, V);
    if (view_) {
      const Two y = body_at(point_of(motion));
      for (Eigen::Index v = 0; v < count_; ++v) {
        stop_point(products_of_view());
        put(view_->write(halves(start_), halves(start_vectors_.col(v)), y, halves(V.col(v)),
                         along(v)),
            V.col(v));
      }
    }
    return as_blocks_ ? by_rows(V, rows_, cols_)
                      : chart_.coordinates(blocks_of(motion), V, by_inertia_);
  }
  Dense basis(const Simulation& motion) const override {
    if (!by_inertia_) return start_basis(motion);
    return by_rows(chart_.basis_of_every_inertia(blocks_of(motion)), rows_, cols_);
  }
  Dense start_basis(const Simulation& motion) const override {
    return by_rows(chart_.basis(blocks_of(motion)), rows_, cols_);
  }

 private:
  using Two = ViewTangent::Two;
  /// The work of reading or writing a vector of a view.
  double products_of_view() const { return 4 * static_cast<double>(chart_.size() * cols_); }
  /// Returns the two blocks of a state or vector, or sets those of a vector.
  Two halves(const Dense& x) const {
    const auto block = x.reshaped(rows_, cols_);
    return {block.topRows(cols_), block.bottomRows(cols_)};
  }
  /// Returns Q and M of the body at a point, which in three dimensions has the rotation Q det Q as
  /// a quaternion.
  Two body_at(const Dense& point) const {
    if (point.cols() > 1) return halves(point);
    return {scene_.determinant() * rotation_matrix<double>(Eigen::Vector4d(point.topRows(4))),
            hat(Eigen::Vector3d(point.bottomRows(3)))};
  }
  void put(const Two& blocks, Eigen::Ref<Eigen::VectorXd> out) const {
    out.reshaped(rows_, cols_) << blocks[0], blocks[1];
  }
  ViewTangent::Along along(Eigen::Index v) const {
    return {parameters_.by_lambda.col(v), scene_.substeps() * parameters_.by_h(v)};
  }
  /// Turns vectors of a body in three dimensions from principal axes to the caller's, or back: δQ
  /// to δQ Tᵀ, δM to T δM Tᵀ; TangentMap's have δ(Q det Q) there.
  void turn(bool to_caller, Dense& V) const {
    if (!(chart_.is_body() || view_) || chart_.size() != 18) return;
    if (!scene_.axes() && scene_.determinant() == 1) return;
    Eigen::Matrix3d T = Eigen::Matrix3d::Identity();
    if (scene_.axes())
      T = to_caller ? scene_.axes()->rotation : scene_.axes()->rotation.transpose();
    for (Eigen::Index k = 0; k < V.cols(); ++k) {
      Dense block = V.col(k).reshaped(6, 3) * T.transpose();
      block.topRows(3) *= scene_.determinant();
      block.bottomRows(3) = (T * block.bottomRows(3)).eval();
      V.col(k) = block.reshaped();
    }
  }

  const Scene scene_;
  bool as_blocks_, by_inertia_;
  std::int64_t first_;
  TangentChart chart_;
  std::unique_ptr<TangentMap> map_;
  Dense point_;
  // Of a view of a body: its derivatives, and where the vectors began.
  std::optional<ViewTangent> view_;
  Dense start_, start_vectors_;
  TangentParameters parameters_;
};

}  // namespace

std::expected<std::unique_ptr<Linearization>, Violations> Linearization::make(
    const Scene& scene, const LinearizationDescription& what, const Simulation& start) {
  const auto refused = [](std::string field, std::string value, std::string rule) {
    return std::unexpected(Violations{{std::move(field), std::move(value), std::move(rule)}});
  };
  if (Violations none = without_tangent(scene); !none.empty())
    return std::unexpected(std::move(none));
  const Dense x = blocks_of(start);
  TangentChart chart(scene, x);
  Dense V;
  if (!what.vectors || !what.as_blocks) {
    if (chart.size() > largest_in_coordinates)
      return refused("vectors", what.vectors ? "coordinates" : "absent",
                     "must be given as blocks: coordinates are offered for states of up to " +
                         std::to_string(largest_in_coordinates) + " numbers");
    V = chart.basis(x);
    if (what.vectors && (what.vectors->rows() != V.cols() || !what.vectors->allFinite()))
      return refused("vectors", std::to_string(what.vectors->rows()) + " coordinates",
                     "must have " + std::to_string(V.cols()) + " finite coordinates each");
    if (what.vectors) V = (V * *what.vectors).eval();
  } else {
    if (what.vectors->rows() != chart.size() || !what.vectors->allFinite())
      return refused("vectors", std::to_string(what.vectors->rows()) + " numbers",
                     "must be finite and " + shape_text(x.rows(), x.cols()) + " each");
    V = by_columns(*what.vectors, x.rows(), x.cols());
    Violations violations;
    for (Eigen::Index k = 0; k < V.cols() && violations.size() < 16; ++k) {
      const Dense G = V.col(k).reshaped(x.rows(), x.cols());
      const double off = (chart.tangent(x, G) - G).norm();
      if (!(off <= tangency * G.norm()))
        violations.push_back(Violation{"vectors[" + std::to_string(k) + "]",
                                       "off by " + to_text(off) + " at norm " + to_text(G.norm()),
                                       "must be tangent to " + to_text(tangency) + " of its norm"});
    }
    if (!violations.empty()) return std::unexpected(std::move(violations));
  }
  return std::make_unique<MovedVectors>(scene, what, std::move(chart), x, V, start);
}

std::uint64_t linearization_bytes(const Scene& scene, std::int64_t vectors, bool in_coordinates) {
  const Tangents* tangents = tangents_of(scene.system());
  if (!tangents) return 0;
  // Counted with malloc: copies of the vectors and of the values of a step, and the bases of a
  // tangent space. A view keeps its first vectors too.
  constexpr double of_values = 8, of_bases = 4, object = 1 << 14;
  const double copies = tangents->view ? 6.5 : 5.5;
  const StateExtent x = extent_of(scene);
  const auto N = static_cast<double>(scene.inertia().size());
  const double m = std::min(static_cast<double>(vectors), x.dimension + N + 1);
  const double basis = !in_coordinates || x.size > Linearization::largest_in_coordinates ? 0
                       : x.is_body ? x.dimension
                                   : of_bases * x.size;
  return static_cast<std::uint64_t>(sizeof(double) * x.size * (copies * m + of_values + basis) +
                                    object) +
         simulation_bytes(scene);
}

}  // namespace stiefel
