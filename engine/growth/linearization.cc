#include "stiefel/linearization.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "engine/dense/so_3.h"
#include "engine/growth/coordinates.h"
#include "engine/growth/tangent_of.h"
#include "engine/motion/observed_simulation.h"
#include "engine/numbers/to_text.h"
#include "engine/scene/scene_draft.h"
#include "stiefel/price.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

constexpr double tangency = 1e-8;

}  // namespace

/// The vectors and the map that moves them.
class Linearization::Vectors {
 public:
  Vectors(const Scene& scene, const LinearizationDescription& what, const Simulation& start)
      : as_blocks_(what.as_blocks), by_inertia_(what.by_inertia), first_(start.step()) {
    if (scene.axes()) R_ = scene.axes()->rotation;
    const Dense x = blocks(start);
    rows_ = x.rows();
    cols_ = x.cols();
    const TangentSpace space = tangents_of(scene.system())->space(scene);
    chart_.emplace(space, rows_, cols_);
    if (by_inertia_ && space.by_inertia) start_by_inertia_ = space.by_inertia(x);
    has_coordinates_ = rows_ * cols_ <= largest_in_coordinates;
  }

  bool has_coordinates() const { return has_coordinates_; }

  /// Makes the map for the vectors V, in principal axes, and the parameters.
  void begin(const Scene& scene, const LinearizationDescription& what, const Dense& V,
             const Simulation& start) {
    const Eigen::VectorXd& lambda = scene.inertia();
    const Eigen::Index inertia = what.by_inertia ? lambda.size() : 0;
    count_ = V.cols() + inertia + (what.by_step ? 1 : 0);
    TangentParameters at{lambda, scene.description().step.value_or(0) / scene.substeps(),
                         Dense::Zero(lambda.size(), count_), Eigen::VectorXd::Zero(count_)};
    at.by_lambda.middleCols(V.cols(), inertia).setIdentity();
    at.by_h.tail(count_ - V.cols() - inertia).setConstant(1.0 / scene.substeps());
    Dense all(rows_ * cols_, count_);
    for (Eigen::Index v = 0; v < count_; ++v) {
      stop_point();
      if (v < V.cols())
        all.col(v) = V.col(v);
      else if (v - V.cols() < start_by_inertia_.cols())
        all.col(v) = start_by_inertia_.col(v - V.cols());
      else
        all.col(v).setZero();
    }
    map_ = tangent_of(scene, scene.method())->make(scene, at);
    map_->start(observed(start), all);
  }

  RunStatus advance(Simulation& motion, std::int64_t steps, const std::stop_token& stop) {
    if (map_->direct()) {
      const RunStatus status = motion.advance(steps, stop);
      if (!status.reached()) return status;
      return unless_stopped(stop, [&] { return map_->at(motion.step() - first_); })
          .value_or(RunStatus{Outcome::cancelled, std::nullopt});
    }
    const auto& state = dynamic_cast<const ObservedSimulation&>(motion);
    for (; steps > 0; --steps) {
      point_ = state.point();
      if (const RunStatus status = motion.advance(1, stop); !status.reached()) return status;
      const RunStatus status = unless_stopped(stop, [&] {
                                 return map_->step(point_);
                               }).value_or(RunStatus{Outcome::cancelled, std::nullopt});
      if (!status.reached()) return status;
    }
    return {};
  }

  /// Returns the vectors as blocks in principal axes.
  Dense read(const Simulation& motion) const {
    Dense V(rows_ * cols_, count_);
    map_->read(observed(motion), V);
    return V;
  }

  const TangentChart& chart() const { return *chart_; }
  bool as_blocks() const { return as_blocks_; }
  bool by_inertia() const { return by_inertia_; }
  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return cols_; }
  Eigen::Index count() const { return count_; }

  /// Returns the state's blocks, stacked, in principal axes.
  Dense blocks(const Simulation& motion) const {
    if (!is_vector(motion)) return observed(motion);
    const Dense& p = observed(motion);
    const Eigen::Index rows = p.rows() == 7 ? 6 : 3;
    Dense x(rows, 3);
    x.bottomRows(3) = hat(Eigen::Vector3d(p.bottomRows(3)));
    if (rows == 6) x.topRows(3) = rotation_matrix<double>(Eigen::Vector4d(p.topRows(4)));
    return x;
  }

  /// Turn vectors (blocks) to the caller's axes and from them; coordinates too.
  Dense to_caller(Dense V) const { return turned(std::move(V), R_); }
  Dense from_caller(Dense V) const { return turned(std::move(V), R_.transpose()); }
  /// Turns a basis, so that its coordinates are the caller's, numbers row by row.
  Dense in_caller_axes(const Dense& B) const {
    const Dense unit = Dense::Identity(B.cols(), B.cols());
    return by_rows(to_caller(B * coordinates_from_caller(unit)), rows_, cols_);
  }
  Dense coordinates_to_caller(const Dense& C) const { return turned_coordinates(C, R_); }
  Dense coordinates_from_caller(const Dense& C) const {
    return turned_coordinates(C, R_.transpose());
  }

 private:
  /// Returns the point, in principal axes. A scene without members has no other simulation.
  static const Dense& observed(const Simulation& motion) {
    return dynamic_cast<const ObservedSimulation&>(motion).point();
  }
  /// Whether the point is (q; m) or m of a body in three dimensions.
  static bool is_vector(const Simulation& motion) {
    const Dense& point = observed(motion);
    return point.cols() == 1 && (point.rows() == 7 || point.rows() == 3) &&
           motion.fields().front().cols == 3;
  }
  /// δQ Tᵀ over T δM Tᵀ.
  Dense turned(Dense V, const Eigen::Matrix3d& T) const {
    if (R_ == Eigen::Matrix3d::Identity()) return V;
    for (Eigen::Index k = 0; k < V.cols(); ++k) {
      Dense block = (V.col(k).reshaped(rows_, 3) * T.transpose()).eval();
      block.bottomRows(3) = (T * block.bottomRows(3)).eval();
      V.col(k) = block.reshaped();
    }
    return V;
  }
  Dense turned_coordinates(const Dense& C, const Eigen::Matrix3d& T) const {
    if (R_ == Eigen::Matrix3d::Identity()) return C;
    Dense out(C.rows(), C.cols());
    for (Eigen::Index top = 0; top < C.rows(); top += 3)
      out.middleRows(top, 3) = T * C.middleRows(top, 3);
    return out;
  }

  bool as_blocks_, by_inertia_, has_coordinates_ = false;
  std::int64_t first_;
  Eigen::Matrix3d R_ = Eigen::Matrix3d::Identity();
  Eigen::Index rows_ = 0, cols_ = 0, count_ = 0;
  std::optional<TangentChart> chart_;
  Dense start_by_inertia_;  ///< the derivatives of the first state by Λ; empty: 0
  std::unique_ptr<TangentMap> map_;
  Dense point_;
};

std::expected<Linearization, Violations> Linearization::make(const Scene& scene,
                                                             LinearizationDescription what,
                                                             const Simulation& start,
                                                             const Place& place) {
  const auto refused = [&](std::string_view field, std::string value, std::string rule) {
    return std::unexpected(Violations{place.violation(field, std::move(value), std::move(rule))});
  };
  if (Violations none = without_tangent(scene, place); !none.empty())
    return std::unexpected(std::move(none));
  auto vectors = std::make_unique<Vectors>(scene, what, start);
  const Eigen::Index rows = vectors->rows(), cols = vectors->cols();
  const bool needs_coordinates = !what.vectors || !what.as_blocks;
  if (needs_coordinates && !vectors->has_coordinates())
    return refused("vectors", what.vectors ? "coordinates" : "absent",
                   "must be given as blocks: coordinates are offered for states of up to " +
                       std::to_string(largest_in_coordinates) + " numbers");
  const Dense x = vectors->blocks(start);
  Dense V;
  if (!what.vectors) {
    V = vectors->chart().basis(x);
    // Columns are unit vectors in the caller's axes.
    const Dense unit = Dense::Identity(V.cols(), V.cols());
    V = (V * vectors->coordinates_from_caller(unit)).eval();
  } else if (!what.as_blocks) {
    const Dense basis = vectors->chart().basis(x);
    if (what.vectors->rows() != basis.cols() || !what.vectors->allFinite())
      return refused("vectors", std::to_string(what.vectors->rows()) + " coordinates",
                     "must have " + std::to_string(basis.cols()) + " finite coordinates each");
    V = basis * vectors->coordinates_from_caller(*what.vectors);
  } else {
    if (what.vectors->rows() != rows * cols || !what.vectors->allFinite())
      return refused("vectors", std::to_string(what.vectors->rows()) + " numbers",
                     "must be finite and " + shape_text(rows, cols) + " each");
    V = vectors->from_caller(by_columns(*what.vectors, rows, cols));
    Violations violations;
    for (Eigen::Index k = 0; k < V.cols() && violations.size() < 16; ++k) {
      const Dense G = V.col(k).reshaped(rows, cols);
      const double off = (vectors->chart().tangent(x, G) - G).norm();
      if (!(off <= tangency * G.norm()))
        violations.push_back(
            place.violation("vectors[" + std::to_string(k) + "]",
                            "off by " + to_text(off) + " at norm " + to_text(G.norm()),
                            "must be tangent to " + to_text(tangency) + " of its norm"));
    }
    if (!violations.empty()) return std::unexpected(std::move(violations));
  }
  vectors->begin(scene, what, V, start);
  return Linearization(std::move(vectors));
}

RunStatus Linearization::advance(Simulation& motion, std::int64_t steps,
                                 const std::stop_token& stop) {
  return vectors_->advance(motion, steps, stop);
}

Dense Linearization::vectors(const Simulation& motion) const {
  const Dense V = vectors_->read(motion);
  if (vectors_->as_blocks()) return by_rows(vectors_->to_caller(V), rows(), cols());
  return vectors_->coordinates_to_caller(
      vectors_->chart().coordinates(vectors_->blocks(motion), V, vectors_->by_inertia()));
}

Dense Linearization::basis(const Simulation& motion) const {
  const Dense x = vectors_->blocks(motion);
  return vectors_->in_caller_axes(vectors_->by_inertia()
                                      ? vectors_->chart().basis_of_every_inertia(x)
                                      : vectors_->chart().basis(x));
}

Dense Linearization::start_basis(const Simulation& motion) const {
  return vectors_->in_caller_axes(vectors_->chart().basis(vectors_->blocks(motion)));
}

Eigen::Index Linearization::rows() const { return vectors_->rows(); }
Eigen::Index Linearization::cols() const { return vectors_->cols(); }
Eigen::Index Linearization::count() const { return vectors_->count(); }

std::uint64_t linearization_bytes(const Scene& scene, std::int64_t vectors, bool in_coordinates) {
  if (!tangents_of(scene.system())) return 0;
  // Counted with malloc: copies of the vectors and of the values of a step, and the bases of a
  // tangent space. Columns of frames are stored in rows of 64.
  constexpr double copies = 5.5, of_values = 8, of_bases = 4, object = 1 << 14, row = 64;
  const StateExtent x = extent_of(scene);
  const auto N = static_cast<double>(scene.inertia().size());
  const double m = std::min(static_cast<double>(vectors), x.dimension + N + 1);
  const double basis = !in_coordinates || x.size > Linearization::largest_in_coordinates ? 0
                       : x.is_body ? x.dimension
                                   : of_bases * x.size;
  const double kept = x.is_body ? x.size : x.size / N * row * std::ceil(N / row);
  return static_cast<std::uint64_t>(
             sizeof(double) * (kept * (copies * m + of_values) + x.size * basis) + object) +
         simulation_bytes(scene);
}

Linearization::Linearization(std::unique_ptr<Vectors> vectors) : vectors_(std::move(vectors)) {}
Linearization::Linearization(Linearization&&) noexcept = default;
Linearization& Linearization::operator=(Linearization&&) noexcept = default;
Linearization::~Linearization() = default;

}  // namespace stiefel
