#include "engine/tangent/coordinates.h"

#include "engine/linalg/lie/so_3.h"
#include "engine/linalg/matrix_equations/decompositions.h"
#include "engine/tangent/systems.h"
#include "stiefel/stop.h"

namespace stiefel {

using Dense = Eigen::MatrixXd;

Dense TangentChart::unit(Eigen::Index k) const {
  if (cols_ == 3) return hat(Eigen::Vector3d(Eigen::Vector3d::Unit(k)));
  Dense E = Dense::Zero(cols_, cols_);
  for (Eigen::Index i = 0, at = 0; i < cols_; ++i)
    for (Eigen::Index j = i + 1; j < cols_; ++j, ++at)
      if (at == k) {
        E(i, j) = 1;
        E(j, i) = -1;
      }
  return E;
}

void TangentChart::write_skew(const Dense& A, Eigen::Ref<Eigen::VectorXd> out) const {
  if (cols_ == 3) {
    out = vee(A);
    return;
  }
  for (Eigen::Index i = 0, at = 0; i < cols_; ++i)
    for (Eigen::Index j = i + 1; j < cols_; ++j) out(at++) = A(i, j);
}

Dense TangentChart::basis(const Dense& x) const {
  const Eigen::Index size = rows_ * cols_;
  if (!is_body()) {
    Dense all(size, size);
    for (Eigen::Index k = 0; k < size; ++k) {
      stop_point(static_cast<double>(rows_ * size));
      Dense G = Dense::Zero(rows_, cols_);
      G(k) = 1;
      all.col(k) = space_.tangent(x, G).reshaped();
    }
    constexpr double least = 1e-7;
    stop_point(4 * static_cast<double>(size * size * size));
    Eigen::ColPivHouseholderQR<Dense> qr(all);
    qr.setThreshold(least);
    return qr.householderQ() * Dense::Identity(size, qr.rank());
  }
  const Eigen::Index half = cols_ * (cols_ - 1) / 2, frame = rows_ > cols_ ? half : 0;
  Dense out = Dense::Zero(size, frame + half);
  for (Eigen::Index k = 0; k < half; ++k) {
    Dense block = Dense::Zero(rows_, cols_);
    const Dense E = unit(k);
    if (frame > 0) {
      block.topRows(cols_) = left() ? Dense(x.topRows(cols_) * E) : Dense(E * x.topRows(cols_));
      out.col(k) = block.reshaped();
    }
    block.setZero();
    block.bottomRows(cols_) = E;
    out.col(frame + k) = block.reshaped();
  }
  return out;
}

Dense TangentChart::coordinates(const Dense& x, const Dense& V) const {
  if (!is_body()) return basis(x).transpose() * V;
  const Eigen::Index half = cols_ * (cols_ - 1) / 2, frame = rows_ > cols_ ? half : 0;
  Dense out(frame + half, V.cols());
  const Eigen::PartialPivLU<Dense> Q(frame > 0 ? Dense(x.topRows(cols_))
                                               : Dense(Dense::Identity(cols_, cols_)));
  for (Eigen::Index k = 0; k < V.cols(); ++k) {
    const Dense block = V.col(k).reshaped(rows_, cols_);
    if (frame > 0) {
      const Dense dQ = block.topRows(cols_);
      const Dense eta = left() ? Dense(Q.solve(dQ)) : Dense(dQ * Q.inverse());
      write_skew(skew_part(eta), out.col(k).head(half));
    }
    write_skew(skew_part(block.bottomRows(cols_)), out.col(k).tail(half));
  }
  return out;
}

Dense TangentChart::tangent(const Dense& x, const Dense& G) const {
  if (!is_body()) return space_.tangent(x, G);
  Dense out(rows_, cols_);
  out.bottomRows(cols_) = skew_part(G.bottomRows(cols_));
  if (rows_ == cols_) return out;
  const Dense Q = x.topRows(cols_), dQ = G.topRows(cols_);
  const Eigen::PartialPivLU<Dense> lu(Q);
  out.topRows(cols_) =
      left() ? Dense(Q * skew_part(lu.solve(dQ))) : Dense(skew_part(dQ * lu.inverse()) * Q);
  return out;
}

StateExtent extent_of(const Scene& scene) {
  const SceneDescription& description = scene.description();
  constexpr double of_body = 18;  // Q and M
  StateExtent out{description.body ? of_body : 0, 0, false, false};
  for (const auto& [name, block] : description.initial) {
    out.size += static_cast<double>(block.values.size() + block.imaginary.size());
    out.is_complex = out.is_complex || block.imaginary.size() > 0;
  }
  const double N = static_cast<double>(scene.dimension()),
               n = static_cast<double>(scene.Q().rows());
  const std::optional<Tangents> tangents = tangents_of(scene.system());
  out.is_body =
      tangents && tangents->space(scene).coordinates != TangentSpace::Coordinates::orthonormal;
  // QQᵀ = I, but for the systems in GL(N), which have a parameter.
  const bool has_frame = n > 0 && !out.is_complex && !description.parameter;
  out.dimension = out.is_body ? N * (N - 1) : out.size - (has_frame ? n * (n + 1) / 2 : 0);
  return out;
}

}  // namespace stiefel
