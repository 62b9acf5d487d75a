#include "engine/frame/geodesics/shoot.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "engine/dense/decompositions.h"
#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/geodesic_flow.h"
#include "engine/frame/geodesics/path.h"
#include "engine/methods/fehlberg.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Moves x over a time T. Returns false when the step size collapses or there are too many steps.
/// `field` writes dx/dt; `work` is the work of one attempt beyond what the field announces. An
/// error may be `tolerance` times 1 + |x| + |dx|, number by number.
template <class Scalar>
bool integrate(const typename Fehlberg<Scalar>::Field& field, std::vector<Scalar>& x, Scalar T,
               Scalar tolerance, double work) {
  constexpr int most = 20000;
  constexpr Scalar safety = Scalar(9) / 10;
  Fehlberg<Scalar> fehlberg;
  std::vector<Scalar> slope(x.size()), next, error;
  Scalar t = 0, dt = T / 32;
  for (int attempt = 0; attempt < most && t < T; ++attempt) {
    stop_point(work);
    dt = std::min(dt, T - t);
    field(x, slope);
    fehlberg.step(field, x, slope, dt, next, error);
    Scalar excess = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
      excess = std::max(excess,
                        std::abs(error[i]) /
                            (tolerance + tolerance * (std::abs(x[i]) + dt * std::abs(slope[i]))));
    if (excess > 1) {
      dt *= std::max(safety * std::pow(excess, Scalar(-1) / 6), Scalar(1) / 5);
    } else {
      t += dt;
      x.swap(next);
      if (excess < Scalar(0.5))
        dt *= safety * std::pow(std::max(excess, std::pow(Scalar(5), Scalar(-8))), Scalar(-1) / 8);
    }
    if (!(dt > T * Scalar(1e-9))) return false;
  }
  return t >= T && std::isfinite(x[0]);
}

template <template <class> class Form>
class Shooting {
 public:
  using Wide = long double;

  static double miss(const VectorXd& lambda, const MatrixXd& Q_0, const MatrixXd& p,
                     const MatrixXd& Q_T, double T) {
    const std::optional<Matrix<Wide>> end = flow<Wide>(lambda, {Q_0, p}, T, 1e-17L);
    if (!end) return std::numeric_limits<double>::infinity();
    return static_cast<double>((*end - Q_T.cast<Wide>()).cwiseAbs().maxCoeff());
  }

  Shooting(const VectorXd& lambda, const MatrixXd& Q_0, const MatrixXd& Q_T)
      : lambda_(lambda), Q_0_(Q_0), Q_T_(Q_T), E_(tangent_basis(Q_0)) {}

  Shot from(const MatrixXd& V, const std::stop_token& stop) const {
    constexpr int iterations = 40, halvings = 6;
    constexpr double good = 1e-12, least_accuracy = 1e-9, most_accuracy = 1e-13;
    VectorXd c = E_.transpose() * V.reshaped();
    VectorXd rest = remainder(c);
    Shot best{velocity(c), rest.cwiseAbs().maxCoeff()};
    double accuracy = least_accuracy;
    for (int k = 0; k < iterations && std::isfinite(best.residual) && !stop.stop_requested(); ++k) {
      const std::optional<MatrixXd> J = derivative(c, accuracy);
      if (!J) break;
      stop_point(2 * static_cast<double>(J->size() * J->cols()));
      VectorXd step = -least_squares(*J, rest);
      const double before = best.residual;
      bool better = false;
      for (int halving = 0; halving < halvings && !better; ++halving, step /= 2) {
        VectorXd trial = c + step, left = remainder(trial);
        if (!(left.norm() < rest.norm())) settle(*J, trial, left);
        better = left.norm() < rest.norm();
        if (!better) continue;
        c = trial;
        rest = left;
      }
      if (const double residual = rest.cwiseAbs().maxCoeff(); residual < best.residual)
        best = {velocity(c), residual};
      const bool much = best.residual < before / 2;
      if (best.residual < good && !much) break;
      if (!better && accuracy == most_accuracy) break;
      if (!better) accuracy = most_accuracy;
    }
    return best;
  }

 private:
  /// Next to a conjugate point Q(1) hardly moves with some directions of c, and a step along them
  /// leaves Q_T by its second order in the others. Removes that remainder with the singular values
  /// of J that are not small.
  void settle(const MatrixXd& J, VectorXd& c, VectorXd& rest) const {
    constexpr double small = 1e-6;  // of the largest squared singular value
    constexpr int most = 12;
    const MatrixXd square = J.transpose() * J;
    const SymmetricEigen<double> spectrum(square);
    const VectorXd& values = spectrum.values();
    const Index soft = (values.array() < small * values(values.size() - 1)).count(),
                stiff = values.size() - soft;
    if (soft == 0) return;
    const MatrixXd Z = spectrum.vectors().rightCols(stiff);
    for (int k = 0; k < most; ++k) {
      const VectorXd y = (Z.transpose() * (J.transpose() * rest)).cwiseQuotient(values.tail(stiff));
      const VectorXd trial = c - Z * y, left = remainder(trial);
      const bool converges = left.norm() < rest.norm() / 2;
      if (left.norm() < rest.norm()) c = trial, rest = left;
      if (!converges) return;
    }
  }

  MatrixXd velocity(const VectorXd& c) const { return (E_ * c).reshaped(Q_0_.rows(), Q_0_.cols()); }
  MatrixXd momentum(const VectorXd& c) const {
    return Form<double>::momentum(lambda_, Q_0_, velocity(c));
  }

  /// Returns Q(1) − Q_T as one column; not finite when the integration fails.
  VectorXd remainder(const VectorXd& c) const {
    const std::optional<Matrix<Wide>> end = flow<Wide>(lambda_, {Q_0_, momentum(c)}, 1, 1e-17L);
    if (!end) return VectorXd::Constant(E_.rows(), std::numeric_limits<double>::infinity());
    return (*end - Q_T_.cast<Wide>()).template cast<double>().reshaped();
  }

  /// Returns dQ(1)/dc, nN × d. Its relative error is the factor by which a Gauss–Newton step
  /// reduces the residual.
  std::optional<MatrixXd> derivative(const VectorXd& c, double accuracy) const {
    std::vector<MatrixXd> blocks = {Q_0_, momentum(c)};
    for (Index j = 0; j < E_.cols(); ++j) {
      blocks.push_back(MatrixXd::Zero(Q_0_.rows(), Q_0_.cols()));
      blocks.push_back(momentum(VectorXd::Unit(E_.cols(), j)));
    }
    MatrixXd all;
    if (!flow<double>(lambda_, blocks, 1, accuracy, &all)) return {};
    MatrixXd J(E_.rows(), E_.cols());
    for (Index j = 0; j < E_.cols(); ++j) J.col(j) = all.col(2 * j + 2);
    return J;
  }

  /// Returns Q(T) from the blocks Q, p and pairs of variations. If `all` is given, it gets every
  /// block as a column.
  template <class Scalar>
  static std::optional<Matrix<Scalar>> flow(const VectorXd& lambda,
                                            const std::vector<MatrixXd>& blocks, double T,
                                            Scalar tolerance, MatrixXd* all = nullptr) {
    const Index n = blocks[0].rows(), size = blocks[0].size();
    GeodesicField<Form<Scalar>, Scalar> field(lambda.cast<Scalar>(), n);
    std::vector<Scalar> x(blocks.size() * static_cast<std::size_t>(size));
    for (std::size_t k = 0; k < blocks.size(); ++k)
      field.block(x, k) = blocks[k].template cast<Scalar>();
    // Otherwise the variations announce work that includes the field's.
    const bool alone = blocks.size() == 2;
    const double work = alone ? connect_work::flow(n, blocks[0].cols()) : 0;
    if (!integrate<Scalar>(std::ref(field), x, Scalar(T), tolerance, work)) return {};
    if (all)
      *all = Eigen::Map<Matrix<Scalar>>(x.data(), size, static_cast<Index>(blocks.size()))
                 .template cast<double>();
    return Matrix<Scalar>(field.block(x, 0));
  }

  VectorXd lambda_;
  MatrixXd Q_0_, Q_T_, E_;
};

}  // namespace

double miss(const VectorXd& lambda, const MatrixXd& Q_0, const MatrixXd& p, const MatrixXd& Q_T,
            double T) {
  return Q_0.rows() == Q_0.cols() ? Shooting<BodyForm>::miss(lambda, Q_0, p, Q_T, T)
                                  : Shooting<FrameForm>::miss(lambda, Q_0, p, Q_T, T);
}

MatrixXd momentum(const VectorXd& lambda, const MatrixXd& Q, const MatrixXd& V) {
  return Q.rows() == Q.cols() ? BodyForm<double>::momentum(lambda, Q, V)
                              : FrameForm<double>::momentum(lambda, Q, V);
}

Shot shoot(const VectorXd& lambda, const MatrixXd& Q_0, const MatrixXd& Q_T, const MatrixXd& V,
           const std::stop_token& stop) {
  return Q_0.rows() == Q_0.cols() ? Shooting<BodyForm>(lambda, Q_0, Q_T).from(V, stop)
                                  : Shooting<FrameForm>(lambda, Q_0, Q_T).from(V, stop);
}

}  // namespace stiefel
