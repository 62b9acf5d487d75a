#include "engine/rigid_body/moser_veselov/j_d_inverse.h"

#include "engine/linalg/iteration/continuation.h"
#include "engine/rigid_body/body/skew_norm.h"
#include "engine/rigid_body/j_d/cayley_n.h"

namespace stiefel {

MatrixWithin<double> J_D_inverse(const Vector<double>& lambda, const Matrix<double>& K) {
  CayleyN<double> cayley(lambda, 1);
  cayley.start(K);
  if (!cayley.newton(K)) {
    cayley.C().setZero();
    Matrix<double> last = cayley.C();
    const double reached = continuation(1, [&](double t) {
      cayley.C() = last;
      const bool found = cayley.newton(t * K);
      if (found) last = cayley.C();
      return found;
    });
    const double norm = skew_norm(K);
    if (!(reached >= 1)) return std::unexpected(OutsideDomain{"J_D(SO(N))", norm, reached * norm});
  }
  const Matrix<double> I = Matrix<double>::Identity(K.rows(), K.cols());
  return Matrix<double>((I - cayley.C()).partialPivLu().solve(I + cayley.C()));
}

}  // namespace stiefel
