#include "engine/growth/coordinates.h"

#include <Eigen/Householder>
#include <cmath>
#include <random>

#include "engine/dense/decompositions.h"
#include "engine/motion/system_entry.h"
#include "stiefel/linearization.h"
#include "stiefel/stop.h"

namespace stiefel {

namespace {

void append(std::string& list, std::string_view name) {
  if (!list.empty()) list += ", ";
  list += name;
}

/// Returns the element whose value is coordinate k of a skew N × N matrix.
std::pair<Eigen::Index, Eigen::Index> element(Eigen::Index N, Eigen::Index k) {
  if (N == 3) return {(k + 2) % 3, (k + 1) % 3};
  Eigen::Index i = 0;
  for (; k >= N - 1 - i; ++i) k -= N - 1 - i;
  return {i, i + 1 + k};
}

}  // namespace

const Tangents* tangents_of(std::string_view system) {
  const SystemEntry* entry = system_entry(system);
  return entry ? entry->tangents : nullptr;
}

const MethodTangent* tangent_of(const Scene& scene, std::string_view method) {
  const Tangents* tangents = tangents_of(scene.system());
  if (!tangents) return nullptr;
  for (const MethodTangent& of : tangents->methods)
    if (of.method == method && (of.dimension == 0 || of.dimension == scene.dimension())) return &of;
  return nullptr;
}

Violations without_tangent(const Scene& scene) {
  if (!scene.members().empty())
    return {Violation{"", std::to_string(scene.members().size()) + " members",
                      "the scene must have no `members`"}};
  if (tangent_of(scene, scene.method())) return {};
  std::string have;
  if (const Tangents* tangents = tangents_of(scene.system())) {
    for (const MethodTangent& of : tangents->methods)
      append(have, std::string(of.method) +
                       (of.dimension > 0 ? " (N = " + std::to_string(of.dimension) + ")" : ""));
    return {Violation{"method", scene.method(),
                      "has no tangent for " + scene.system() +
                          " at N = " + std::to_string(scene.dimension()) + "; " + have + " have"}};
  }
  for (const SystemEntry& entry : system_entries())
    if (entry.tangents) append(have, entry.info.name);
  return {
      Violation{"system", scene.system(), "has no tangent by any method; " + have + " have one"}};
}

Dense by_columns(const Dense& V, Eigen::Index rows, Eigen::Index cols) {
  Dense out(V.rows(), V.cols());
  for (Eigen::Index k = 0; k < V.cols(); ++k) {
    stop_point();
    out.col(k).reshaped(rows, cols) = V.col(k).reshaped<Eigen::RowMajor>(rows, cols);
  }
  return out;
}
Dense blocks_of(const Simulation& motion) {
  Dense x;
  for (std::size_t i = 0; i < motion.block_count(); ++i) {
    const Dense block = motion.get(motion.fields()[i].name);
    x.conservativeResize(x.rows() + block.rows(), block.cols());
    x.bottomRows(block.rows()) = block;
  }
  return x;
}

TangentChart::TangentChart(const Scene& scene, const Dense& x)
    : space_(tangents_of(scene.system())->space(scene)), rows_(x.rows()), cols_(x.cols()) {}

/// Householder's reflections of the longest column that is left.
Dense orthonormal_range(Dense A) {
  constexpr double least = 1e-7;
  const Eigen::Index m = A.rows();
  Eigen::VectorXd factors(m), workspace(m);
  double first = 0, beta = 0;
  Eigen::Index rank = 0;
  for (; rank < A.cols(); ++rank) {
    const Eigen::Index left = m - rank, others = A.cols() - rank;
    stop_point(3 * static_cast<double>(left * others));
    Eigen::Index longest;
    const double length =
        std::sqrt(A.bottomRightCorner(left, others).colwise().squaredNorm().maxCoeff(&longest));
    if (rank == 0) first = length;
    if (!(length > least * first)) break;
    A.col(rank).swap(A.col(rank + longest));
    A.col(rank).tail(left).makeHouseholderInPlace(factors(rank), beta);
    A.bottomRightCorner(left, others - 1)
        .applyHouseholderOnTheLeft(A.col(rank).tail(left - 1), factors(rank), workspace.data());
  }
  Dense Q = Dense::Identity(m, rank);
  for (Eigen::Index k = rank - 1; k >= 0; --k) {
    stop_point(2 * static_cast<double>((m - k) * (rank - k)));
    Q.bottomRightCorner(m - k, rank - k)
        .applyHouseholderOnTheLeft(A.col(k).tail(m - k - 1), factors(k), workspace.data());
  }
  return Q;
}

Dense TangentChart::tangents(
    const Dense& x, const std::function<Dense(const Dense&, const Dense&)>& tangent) const {
  Dense all(size(), size());
  for (Eigen::Index k = 0; k < size(); ++k) {
    stop_point(static_cast<double>(rows_ * size()));
    Dense G = Dense::Zero(rows_, cols_);
    G(k) = 1;
    all.col(k) = tangent(x, G).reshaped();
  }
  return all;
}

Dense TangentChart::basis_of_every_inertia(const Dense& x) const {
  Dense B = basis(x);
  if (!space_.tangent_of_every_inertia) return B;
  Dense rest = tangents(x, space_.tangent_of_every_inertia);
  for (int pass = 0; pass < 2; ++pass) rest -= (B * (B.transpose() * rest)).eval();
  rest = orthonormal_range(std::move(rest));
  const Eigen::Index d = B.cols();
  B.conservativeResize(Eigen::NoChange, d + rest.cols());
  B.rightCols(rest.cols()) = rest;
  return B;
}

Dense TangentChart::basis(const Dense& x) const {
  if (!is_body()) return orthonormal_range(tangents_of_units(x));
  const Eigen::Index frame = has_frame() ? half() : 0;
  Dense out = Dense::Zero(size(), frame + half());
  for (Eigen::Index k = 0; k < half(); ++k) {
    const auto [i, j] = element(cols_, k);
    auto at = [&](Eigen::Index column) { return out.col(column).reshaped(rows_, cols_); };
    if (has_frame()) {  // Q E_k
      at(k).topRows(cols_).col(j) = x.topRows(cols_).col(i);
      at(k).topRows(cols_).col(i) = -x.topRows(cols_).col(j);
    }
    at(frame + k).bottomRows(cols_)(i, j) = 1;
    at(frame + k).bottomRows(cols_)(j, i) = -1;
  }
  return out;
}

Dense TangentChart::coordinates(const Dense& x, const Dense& V, bool of_every_inertia) const {
  if (!is_body()) return (of_every_inertia ? basis_of_every_inertia(x) : basis(x)).transpose() * V;
  const Eigen::Index frame = has_frame() ? half() : 0;
  Dense out(frame + half(), V.cols());
  const Lu<double> Q(has_frame() ? Dense(x.topRows(cols_)) : Dense(Dense::Identity(cols_, cols_)));
  for (Eigen::Index v = 0; v < V.cols(); ++v) {
    const Dense block = V.col(v).reshaped(rows_, cols_);
    const Dense eta = has_frame() ? skew_part(Q.solve(block.topRows(cols_))) : Dense(),
                dM = skew_part(block.bottomRows(cols_));
    for (Eigen::Index k = 0; k < half(); ++k) {
      const auto [i, j] = element(cols_, k);
      if (has_frame()) out(k, v) = eta(i, j);
      out(frame + k, v) = dM(i, j);
    }
  }
  return out;
}

Dense TangentChart::tangent(const Dense& x, const Dense& G) const {
  stop_point(4 * static_cast<double>(cols_ * G.size()));
  if (!is_body()) return space_.tangent(x, G);
  Dense out(rows_, cols_);
  out.bottomRows(cols_) = skew_part(G.bottomRows(cols_));
  if (!has_frame()) return out;
  const Dense Q = x.topRows(cols_), dQ = G.topRows(cols_);
  out.topRows(cols_) = Q * skew_part(Lu<double>(Q).solve(dQ));
  return out;
}

GrowthVectors::GrowthVectors(const Scene& scene, const Simulation& start)
    : chart_(scene, blocks_of(start)) {
  const Dense x = blocks_of(start);
  Dense weights(x.rows(), x.cols());
  for (Eigen::Index top = 0, b = 0; top < x.rows(); ++b) {
    const Eigen::Index height = start.fields()[static_cast<std::size_t>(b)].rows;
    const double norm = x.middleRows(top, height).norm();
    weights.middleRows(top, height)
        .setConstant(norm > 0 ? std::sqrt(static_cast<double>(height)) / norm : 1);
    top += height;
  }
  weights_ = weights.reshaped();
}

std::int64_t GrowthVectors::dimension(const Dense& x) const {
  if (chart_.is_body()) return x.cols() * (x.cols() - 1) / 2 * (x.rows() > x.cols() ? 2 : 1);
  if (size() > Linearization::largest_in_coordinates) return 0;
  return orthonormal_range(weights_.asDiagonal() * chart_.tangents_of_units(x) *
                           weights_.cwiseInverse().asDiagonal())
      .cols();
}

Dense GrowthVectors::random(const Dense& x, Eigen::Index k, std::uint64_t seed) const {
  std::mt19937_64 bits(seed);
  Dense V(size(), k);
  for (Eigen::Index j = 0; j < k; ++j) {
    stop_point();
    for (double& v : V.col(j)) v = static_cast<double>(bits() >> 11) * 0x1p-52 - 1;  // in (−1, 1)
  }
  V = weights_.cwiseInverse().asDiagonal() * V;
  orthonormalise(x, V);
  return V;
}

Dense GrowthVectors::orthonormalise(const Dense& x, Dense& V) const {
  const Eigen::Index k = V.cols();
  Dense R = Dense::Zero(k, k);
  for (Eigen::Index j = 0; j < k; ++j) {
    stop_point(static_cast<double>((4 * j + 8 * x.cols()) * size()));
    V.col(j) =
        weights_.cwiseProduct(chart_.tangent(x, V.col(j).reshaped(x.rows(), x.cols())).reshaped());
    for (int pass = 0; pass < 2; ++pass)
      for (Eigen::Index i = 0; i < j; ++i) {
        const double part = V.col(i).dot(V.col(j));
        V.col(j) -= part * V.col(i);
        R(i, j) += part;
      }
    R(j, j) = V.col(j).norm();
    V.col(j) /= R(j, j);
  }
  V = weights_.cwiseInverse().asDiagonal() * V;
  return R;
}

StateExtent extent_of(const Scene& scene) {
  const SceneDescription& description = scene.description();
  constexpr double of_body = 18;  // Q and M
  StateExtent out{description.body ? of_body : 0, 0, false};
  for (const auto& [name, block] : description.initial)
    out.size += static_cast<double>(block.values.size());
  const double N = static_cast<double>(scene.dimension()),
               n = static_cast<double>(scene.Q().rows());
  out.is_body = !tangents_of(scene.system())->space(scene).tangent;
  out.dimension = out.is_body ? N * (N - 1) : out.size - n * (n + 1) / 2;
  return out;
}

}  // namespace stiefel
