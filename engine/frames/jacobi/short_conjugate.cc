#include "engine/frames/jacobi/short_conjugate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/frames/geodesics/path.h"
#include "engine/frames/jacobi/posed_metric.h"
#include "stiefel/stop.h"

namespace stiefel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

ShortConjugates::ShortConjugates(const VectorXd& lambda, Index n)
    : lambda_(lambda), n_(n), N_(lambda.size()), flow_(JacobiFlow::make(lambda, n)) {}

MatrixXd ShortConjugates::unit(const MatrixXd& Q, const MatrixXd& V) const {
  const MatrixXd tangent = PosedMetric::tangent(Q, V);
  return tangent / std::sqrt((tangent.cwiseAbs2() * lambda_).sum());
}

std::optional<Conjugated> ShortConjugates::first(const MatrixXd& Q, const MatrixXd& V,
                                                 double limit) const {
  ConjugateSearch search(lambda_, Q, V);
  std::vector<Crossing> found;
  while (found.empty() && search.length() < limit)
    if (!search.advance(limit, found)) return {};
  if (found.empty()) return {};
  return Conjugated{Q, V, std::move(found.front())};
}

std::optional<JacobiFlow::State> ShortConjugates::moved(JacobiFlow::State x, double length) const {
  constexpr double tolerance = 1e-14;
  constexpr int most = 20000;
  JacobiFlow::State next, errors;
  double h = std::min(length, 0.2 / flow_->curvature(x));
  for (int k = 0; k < most; ++k) {
    if (!(length > 0)) return x;
    h = std::min(h, length);
    flow_->step(x, h, next, errors);
    double error = 0, size = 0;
    for (std::size_t i = 0; i < next.size(); ++i) {
      error = std::max(error, std::abs(errors[i]));
      size = std::max(size, std::abs(next[i]));
    }
    if (!std::isfinite(size)) return {};
    const double factor = 0.9 * std::pow(tolerance * size / (error + 1e-300), 0.125);
    if (error <= 2 * tolerance * size) {
      std::swap(x, next);
      length -= h;
    }
    h *= std::clamp(factor, 0.2, 4.0);
  }
  return {};
}

VectorXd ShortConjugates::gradient(const Conjugated& at) const {
  constexpr double epsilon = 1e-6;
  const Index size = n_ * N_;
  const double c = at.point.length;
  const MatrixXd w = at.point.kernel.col(0).reshaped(n_, N_), Z = tangent_basis(at.Q);
  VectorXd result = VectorXd::Zero(2 * size);
  const auto end = moved(flow_->start(at.Q, at.V, w.reshaped()), c);
  if (!end) return result;
  const auto [A, B] = flow_->coordinates(*end);
  const MatrixXd E = flow_->basis(flow_->frame(*end));
  const double rate = B.norm();
  const VectorXd u = (E * (B / rate)).cwiseProduct(lambda_.transpose().replicate(n_, 1).reshaped());
  const auto tested = [&](const MatrixXd& Q, const MatrixXd& V) {
    const MatrixXd field = PosedMetric::tangent(Q, w);
    auto x = moved(flow_->start(Q, V, field.reshaped()), c);
    return x ? u.dot(flow_->fields(*x).col(0).head(size)) : 0.0;
  };
  const auto slope = [&](Index k, bool of_frame) {
    const MatrixXd move = epsilon * Z.col(k).reshaped(n_, N_);
    const auto moved_by = [&](double sign) {
      const MatrixXd Q = of_frame ? polar(at.Q + sign * move) : at.Q;
      return tested(Q, unit(Q, of_frame ? at.V : MatrixXd(at.V + sign * move)));
    };
    return -(moved_by(1) - moved_by(-1)) / (2 * epsilon * rate);
  };
  for (Index k = 0; k < Z.cols(); ++k) {
    if (n_ < N_) result.head(size) += slope(k, true) * Z.col(k);
    result.tail(size) += slope(k, false) * Z.col(k);
  }
  return result;
}

Conjugated ShortConjugates::descended(Conjugated at) {
  constexpr int iterations = 80, halvings = 12;
  constexpr double flat = 1e-7, enough = 1e-4, settled = 1e-13;
  const Index size = n_ * N_;
  MatrixXd inverse = MatrixXd::Identity(2 * size, 2 * size);
  VectorXd slope = gradient(at);
  for (int k = 0; k < iterations; ++k) {
    if (slope.norm() <= flat * at.point.length) break;
    VectorXd move = -inverse * slope;
    if (move.dot(slope) >= 0) {
      inverse.setIdentity();
      move = -slope;
    }
    move *= std::min(1.0, 0.5 / move.norm());
    std::optional<Conjugated> better;
    for (int half = 0; half < halvings && !better; ++half) {
      const MatrixXd Q = n_ < N_ ? polar(at.Q + move.head(size).reshaped(n_, N_)) : at.Q;
      better = first(Q, unit(Q, at.V + move.tail(size).reshaped(n_, N_)), 1.2 * at.point.length);
      if (better && better->point.length > at.point.length + enough * move.dot(slope))
        better.reset();
      if (!better) move /= 2;
    }
    if (!better) break;
    const double gain = at.point.length - better->point.length;
    at = std::move(*better);
    if (gain <= settled * at.point.length) break;
    const VectorXd next = gradient(at), change = next - slope;
    const double curvature = change.dot(move);
    if (curvature > 1e-12 * change.norm() * move.norm()) {
      const VectorXd Hy = inverse * change;
      inverse += (curvature + change.dot(Hy)) / (curvature * curvature) * move * move.transpose() -
                 (Hy * move.transpose() + move * Hy.transpose()) / curvature;
    }
    slope = next;
  }
  return at;
}

}  // namespace stiefel
