#include "engine/catalogue/motions/motion_starts.h"

#include "engine/parametric/parametric_invariants.h"
#include "engine/linalg/lie/principal_moments_3.h"
#include "engine/linalg/lie/so_3.h"
#include "engine/rigid_body/symmetric/mclachlan_scovel_blocks.h"
#include "engine/frames/body/stiefel_legendre.h"
#include "engine/frames/body/stiefel_momenta.h"
#include "engine/catalogue/motions/series_start.h"
#include "engine/scene/given_axes.h"

namespace stiefel {
namespace {

/// Returns the frame nearest to a Q whose rows are orthonormal to rounding in double precision.
/// Each of two iterations of Newton and Schulz squares the defect, which is 1e-16 at first.
template <class Scalar>
Matrix<Scalar> orthonormal(Matrix<Scalar> Q) {
  for (int k = 0; k < 2; ++k) {
    const Matrix<Scalar> defect = Matrix<Scalar>::Identity(Q.rows(), Q.rows()) - Q * Q.transpose();
    Q += (defect * Q / 2).eval();
  }
  return Q;
}

/// The numbers of a scene in Scalar.
template <class Scalar>
struct Given {
  using Dense = Matrix<Scalar>;
  using Start = SeriesStart<Scalar>;

  explicit Given(const Scene& of)
      : scene(of), lambda(numbers(of.inertia())), mu(of.parameter()), epsilon(of.epsilon()) {}

  static auto numbers(const auto& v) { return v.template cast<Scalar>().eval(); }
  Dense block(const char* name) const { return numbers(scene.block(name)); }
  Start start(const SeriesEquations& equations, const Dense& frame, const Dense& momentum) const {
    Start start{&equations, lambda, {}, mu, Dense(frame.rows() + momentum.rows(), momentum.cols()),
                {}};
    if (frame.size() > 0) start.x.topRows(frame.rows()) = frame;  // a scene with M alone has none
    start.x.bottomRows(momentum.rows()) = momentum;
    return start;
  }
  Start body(const Dense& Q, const Dense& M) const {
    return start(series_equations::rigid_body, Q, M);
  }

  const Scene& scene;
  Vector<Scalar> lambda;
  Scalar mu, epsilon;
};

/// Returns the start of a body given in engineers' terms; [I, R] are its principal axes.
template <class Scalar>
SeriesStart<Scalar> given_body(const Given<Scalar>& g, const BodyDescription& given) {
  using Dense = Matrix<Scalar>;
  const auto [I, R] = given_axes<Scalar>(given);
  const auto q = g.numbers(Eigen::Vector4d(given.attitude.data()));
  const auto omega = g.numbers(Eigen::Vector3d(given.angular_velocity.data()));
  const Vector3<Scalar> m = I.cwiseProduct(R.transpose() * omega);
  using std::sqrt;
  const Dense attitude = rotation_matrix<Scalar>((q / sqrt(Scalar(q.squaredNorm()))).eval()) * R;
  auto start = g.body(attitude, hat(m));
  start.lambda =
      PrincipalMoments3<Scalar>(I, Vector3<Scalar>(I(1) - I(2), I(2) - I(0), I(0) - I(1))).lambda();
  start.presentation.axes = R;
  return start;
}

struct Body {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    if (const auto& given = g.scene.description().body) return given_body(g, *given);
    return g.body(g.block("Q"), g.block("M"));
  }
};

/// Marks the start of a left-invariant motion as that of the right-invariant motion it represents,
/// [RB] Prop. 2.1.
template <class Scalar>
SeriesStart<Scalar> seen_from_the_right(SeriesStart<Scalar> start) {
  start.presentation.right = true;
  return start;
}

struct RightBody {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    return seen_from_the_right(g.body(g.block("Q").transpose(), -g.block("M")));
  }
};

struct SymmetricBody {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    const Matrix<Scalar> Q = g.block("Q");
    return g.body(Q, dense_M<Scalar>(Q, g.block("P")) / g.epsilon);
  }
};

struct RightSymmetricBody {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    const Matrix<Scalar> Q = g.block("Q").transpose(), P = g.block("P").transpose();
    return seen_from_the_right(g.body(Q, dense_M<Scalar>(Q, P) / g.epsilon));
  }
};

struct ReducedBody {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    const Matrix<Scalar> Q = g.block("Q");
    return g.body(Q, Q.transpose() * momentum_m<Scalar>(Q, g.block("P")) * Q / g.epsilon);
  }
};

struct McLachlanScovelBody {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    const Matrix<Scalar> Q = g.block("Q");
    return g.body(Q, M_of_B<Scalar>(Q, g.block("B")));
  }
};

struct ParametricBody {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    const Matrix<Scalar> Q = g.block("Q");
    auto start = g.start(series_equations::parametric_rigid_body, Q,
                         parametric_momentum<Scalar>(Q, g.block("P")) / g.epsilon);
    start.presentation.diagonal = g.mu * g.lambda.cwiseAbs2();
    return start;
  }
};

struct TwoFrames {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    const Matrix<Scalar> Q = g.block("Q"),
                         W = g.lambda.asDiagonal() * (g.block("Q_prev").transpose() * Q);
    return g.body(Q, (W - W.transpose()) / Scalar(g.scene.step()));
  }
};

struct Tangent {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    return g.start(series_equations::stiefel, g.block("Q"), g.block("S"));
  }
};

/// Returns the start from a costate, by 𝔐⁻¹.
template <class Scalar>
SeriesStart<Scalar> of_costate(const Given<Scalar>& g, const char* frame, const char* costate) {
  const Matrix<Scalar> Q = orthonormal<Scalar>(g.block(frame));
  return g.start(series_equations::stiefel, Q,
                 Legendre_inverse<Scalar>(g.lambda, Q, g.block(costate)));
}

struct Costate {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    return of_costate(g, "Q", "P");
  }
};

struct VectorOfOne {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    if (g.scene.block("p").size() > 0) return of_costate(g, "q", "p");
    return g.start(series_equations::stiefel, g.block("q"),
                   S_of_Qdot<Scalar>(g.lambda, g.block("qdot")));
  }
};

struct DoubleBracketPair {
  template <class Scalar>
  static SeriesStart<Scalar> of(const Given<Scalar>& g) {
    const auto vector = [&](const std::vector<double>& l) -> Vector<Scalar> {
      return g.numbers(
          Eigen::Map<const Eigen::VectorXd>(l.data(), static_cast<Eigen::Index>(l.size())));
    };
    auto start = g.start(series_equations::double_bracket, g.block("Q"), g.block("P"));
    start.lambda = vector(g.scene.description().inertia_u);
    start.lambda_v = vector(g.scene.description().inertia_v);
    start.presentation.complex = true;
    return start;
  }
};

template <class Variables>
constexpr MotionStart in_both = {
    [](const Scene& scene) { return Variables::of(Given<long double>(scene)); },
    [](const Scene& scene) { return Variables::of(Given<Quad>(scene)); }};

}  // namespace

namespace motion_start {
constinit const MotionStart body = in_both<Body>;
constinit const MotionStart right_body = in_both<RightBody>;
constinit const MotionStart symmetric_body = in_both<SymmetricBody>;
constinit const MotionStart right_symmetric_body = in_both<RightSymmetricBody>;
constinit const MotionStart reduced_body = in_both<ReducedBody>;
constinit const MotionStart mclachlan_scovel = in_both<McLachlanScovelBody>;
constinit const MotionStart parametric_body = in_both<ParametricBody>;
constinit const MotionStart two_frames = in_both<TwoFrames>;
constinit const MotionStart tangent = in_both<Tangent>;
constinit const MotionStart costate = in_both<Costate>;
constinit const MotionStart vector = in_both<VectorOfOne>;
constinit const MotionStart double_bracket = in_both<DoubleBracketPair>;
}  // namespace motion_start

}  // namespace stiefel
