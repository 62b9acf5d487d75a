#include "engine/body/j_d/j_d_n.h"

#include <optional>

#include "engine/body/j_d/cayley_n.h"
#include "engine/body/j_d/deviation_n.h"
#include "engine/body/j_d/rotation_n.h"

namespace stiefel {

template class CayleyN<double>;

Eigen::MatrixXd rotation_weights(const Eigen::VectorXd& lambda) {
  return Eigen::MatrixXd::NullaryExpr(
      lambda.size(), lambda.size(), [&](Eigen::Index i, Eigen::Index j) {
        return i == j ? 1.0 : 2 * lambda(i) / (lambda(i) + lambda(j));
      });
}

double norm_of_skew(const Eigen::MatrixXd& A, Eigen::VectorXd& v, Eigen::VectorXd& Av) {
  constexpr int steps = 6;
  Eigen::Index longest;
  A.cwiseAbs().colwise().maxCoeff().maxCoeff(&longest);
  v = A.col(longest);
  double norm = v.stableNorm();
  for (int k = 0; k < steps && norm > 0; ++k) {
    v /= norm;
    Av.noalias() = A * v;
    norm = Av.stableNorm();
    v.swap(Av);
  }
  return 1.1 * norm;
}

/// The three forms of the equation.
struct JDInverseN::Forms {
  Forms(const Eigen::VectorXd& lambda, double step)
      : h(step),
        N(lambda.size()),
        wide_spread(!(lambda.minCoeff() * widest > lambda.maxCoeff())),
        deviation(lambda.head(wide_spread ? 0 : N), h),
        cayley(lambda, h),
        K(N, N),
        found(N, N) {
    if (wide_spread && N >= least_rotation && !(lambda.minCoeff() < 0)) rotation.emplace(lambda, h);
  }

  bool newton() {
    if (!cayley.newton(K)) return false;
    if (!wide_spread) deviation.set(cayley.deviation(), K);
    return true;
  }

  /// Largest λ_max/λ_min for which the deviation form keeps its digits.
  static constexpr double widest = 64;
  /// Smallest N whose steps take less time in the rotation form than in the Cayley form.
  static constexpr Eigen::Index least_rotation = 5;

  double h;
  Eigen::Index N;
  bool wide_spread, in_rotation_form = false;
  DeviationN deviation;
  CayleyN<double> cayley;
  std::optional<RotationN> rotation;
  Eigen::MatrixXd K, found;
};

JDInverseN::JDInverseN(const Eigen::VectorXd& lambda, double h) {
  const double unit = binary_unit(lambda.maxCoeff());
  forms_ = std::make_unique<Forms>(lambda / unit, h / unit);
  const Eigen::Index N = lambda.size();
  const bool square = forms_->wide_spread && !forms_->rotation;
  memory_rows_ = square ? N : N * (N + 1) / 2;
  memory_columns_ = square ? N : 1;
}
JDInverseN::JDInverseN(JDInverseN&&) noexcept = default;
JDInverseN::~JDInverseN() = default;

bool JDInverseN::solve(const State& x, const Memory& memory) {
  Forms& f = *forms_;
  const auto times_h = [&](Eigen::Index begin, Eigen::Index end) {
    auto columns = f.K.middleCols(begin, end - begin);
    columns = f.h * x.value.bottomRows(f.N).middleCols(begin, end - begin);
    return columns.allFinite() ? 0.0 : 1.0;
  };
  if (largest_in_column_ranges<double>(f.N, static_cast<double>(f.N), times_h) > 0) return false;
  f.in_rotation_form = false;
  if (f.rotation) {
    if (!memory.predict(f.rotation->S())) f.rotation->S().setZero();
    f.in_rotation_form = f.rotation->solve(f.K, x.compensated);
    if (f.in_rotation_form) return true;
  }
  if (f.wide_spread) {
    if (f.rotation || !memory.predict(f.cayley.C())) f.cayley.start(f.K);
    if (f.cayley.fixed_point(f.K)) return true;
  } else {
    if (!memory.predict(f.deviation.R())) f.deviation.R().setZero();
    if (f.deviation.sweep(f.K, x.compensated)) return true;
  }
  f.cayley.start(f.K);
  return f.newton();
}

bool JDInverseN::continue_to(const State& x, double t) {
  Forms& f = *forms_;
  f.K = (t * f.h) * x.value.bottomRows(f.N);
  f.found = f.cayley.C();
  if (f.newton()) return true;
  f.cayley.C() = f.found;
  return false;
}
void JDInverseN::restart() { forms_->cayley.C().setZero(); }

void JDInverseN::transport(State& x, Memory& memory) {
  Forms& f = *forms_;
  if (f.in_rotation_form) {
    f.rotation->transport(x);
    memory.push(f.rotation->S());
  } else if (!f.wide_spread) {
    f.deviation.transport(x);
    memory.push(f.deviation.R());
  } else {
    f.cayley.transport(x);
    if (!f.rotation) return memory.push(f.cayley.C());
    f.rotation->set(f.cayley.U_minus_I());
    memory.push(f.rotation->S());
  }
}

const Eigen::MatrixXd& JDInverseN::U_minus_I() {
  Forms& f = *forms_;
  if (f.in_rotation_form) return f.rotation->U_minus_I();
  return f.wide_spread ? f.cayley.U_minus_I() : f.deviation.U_minus_I();
}

}  // namespace stiefel
