#include "engine/body/j_d/j_d_n.h"

#include "engine/body/j_d/cayley_n.h"
#include "engine/body/j_d/rotation_n.h"

namespace stiefel {

template class CayleyN<double>;

/// The two forms of the equation.
struct JDInverseN::Forms {
  double h;
  Eigen::Index N;
  bool in_rotation_form = false;
  RotationN rotation;
  CayleyN<double> cayley;
  Eigen::MatrixXd K, found;
};

JDInverseN::JDInverseN(const Eigen::VectorXd& lambda, double h)
    : packed_size_(lambda.size() * (lambda.size() + 1) / 2) {
  const double unit = binary_unit(lambda.maxCoeff());
  const Eigen::VectorXd of_one = lambda / unit;
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(lambda.size(), lambda.size());
  forms_ = std::make_unique<Forms>(h / unit, lambda.size(), false, RotationN(of_one, h / unit),
                                   CayleyN<double>(of_one, h / unit), zero, zero);
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
  if (!memory.predict(f.rotation.S())) f.rotation.S().setZero();
  f.in_rotation_form = f.rotation.solve(f.K, x.compensated);
  if (f.in_rotation_form) return true;
  f.cayley.start(f.K);
  if (f.cayley.fixed_point(f.K)) return true;
  f.cayley.start(f.K);
  return f.cayley.newton(f.K);
}

bool JDInverseN::continue_to(const State& x, double t) {
  Forms& f = *forms_;
  f.K = (t * f.h) * x.value.bottomRows(f.N);
  f.found = f.cayley.C();
  if (f.cayley.newton(f.K)) return true;
  f.cayley.C() = f.found;
  return false;
}
void JDInverseN::restart() { forms_->cayley.C().setZero(); }

void JDInverseN::transport(State& x, Memory& memory) {
  Forms& f = *forms_;
  if (f.in_rotation_form) {
    f.rotation.transport(x);
  } else {
    f.cayley.transport(x);
    f.rotation.set(f.cayley.U_minus_I());
  }
  memory.push(f.rotation.S());
}

const Eigen::MatrixXd& JDInverseN::U_minus_I() {
  return forms_->in_rotation_form ? forms_->rotation.U_minus_I() : forms_->cayley.U_minus_I();
}

}  // namespace stiefel
