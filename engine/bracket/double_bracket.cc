#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "engine/bracket/double_bracket.h"
#include "engine/bracket/taylor_double_bracket.h"
#include "engine/dense/decompositions.h"
#include "engine/motion/make_simulation.h"
#include "engine/motion/observables.h"
#include "engine/motion/series_start.h"
#include "engine/motion/system_entry.h"
#include "engine/scene/scene_draft.h"
#include "stiefel/invariant_names.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

bool check_positive(SceneDraft& draft, const std::string& field, const std::vector<double>& l) {
  if (l.empty() || l.size() > Scene::max_dimension / 2) {
    draft.refuse(field, std::to_string(l.size()) + " numbers",
                 "must have 1 to " + std::to_string(Scene::max_dimension / 2) + " numbers");
    return false;
  }
  for (std::size_t k = 0; k < l.size(); ++k)
    if (!(l[k] > 0) || !std::isfinite(l[k])) {
      draft.refuse(field + "[" + std::to_string(k) + "]", to_text(l[k]), "must be finite and > 0");
      return false;
    } else if (!draft.check_number(field + "[" + std::to_string(k) + "]", "λ", l[k])) {
      return false;
    }
  return true;
}

void check_double_bracket(SceneDraft& draft) {
  auto& given = draft.given();
  draft.refuse_if(given.body.has_value(), "body");
  draft.refuse_if(given.epsilon.has_value(), "epsilon");
  draft.refuse_if(given.parameter.has_value(), "parameter");
  draft.refuse_if(!given.inertia.empty(), "inertia");
  draft.check_block_names(true);
  const bool u = check_positive(draft, "inertia_u", given.inertia_u);
  const bool v = check_positive(draft, "inertia_v", given.inertia_v);
  if (!u || !v) return;
  const auto p = static_cast<Eigen::Index>(given.inertia_u.size());
  const auto q = static_cast<Eigen::Index>(given.inertia_v.size());
  for (const char* name : {"Q", "P"}) {
    const RowMatrix* real = draft.block(name, p, q);
    if (real == nullptr) continue;
    const RowMatrix& imaginary = given.initial.at(name).imaginary;
    Eigen::MatrixXd stored = Eigen::MatrixXd::Zero(2 * p, q);
    stored.topRows(p) = *real;
    if (imaginary.size() > 0) stored.bottomRows(p) = imaginary;
    draft.set_block(name, stored);
  }
}

Eigen::VectorXd vector(const std::vector<double>& l) {
  return Eigen::VectorXd::Map(l.data(), static_cast<Eigen::Index>(l.size()));
}

constexpr auto double_bracket_start = [](const auto& g) {
  auto made = g.start(g.block("Q"), g.block("P"));
  made.lambda = g.numbers(vector(g.scene.description().inertia_u));
  made.lambda_v = g.numbers(vector(g.scene.description().inertia_v));
  made.reported.complex = true;
  return made;
};

bool of_scalars(const Scene& scene) {
  return scene.description().inertia_u.size() == 1 && scene.description().inertia_v.size() == 1;
}

constexpr std::array for_double_bracket = {
    // U and V are constant, so a step by the exponential is exact.
    Recommendation{
        .where = "1 x 1 blocks", .takes = of_scalars, .method = "munthe_kaas4", .order = 4},
    with_error_control(1e-13)};

FrameSize size(const Scene& scene) {
  const SceneDescription& given = scene.description();
  return {static_cast<double>(given.inertia_u.size()), static_cast<double>(given.inertia_v.size())};
}

using Complex = std::complex<double>;

Eigen::MatrixXcd complex_block(const Eigen::MatrixXd& x, Eigen::Index first, Eigen::Index p) {
  return x.middleRows(first, p).cast<Complex>() +
         Complex(0, 1) * x.middleRows(first + p, p).cast<Complex>();
}

std::unique_ptr<Simulation> make_double_bracket(const Scene& scene) {
  const Eigen::VectorXd lambda_u = vector(scene.description().inertia_u);
  const Eigen::VectorXd lambda_v = vector(scene.description().inertia_v);
  const int p = static_cast<int>(lambda_u.size()), q = static_cast<int>(lambda_v.size());
  Eigen::MatrixXd state(4 * p, q);
  state << scene.block("Q"), scene.block("P");
  Observables observables(state);
  for (const auto& [name, first] : {std::pair("Q", 0), std::pair("P", 2 * p)})
    observables.computed_block({name, p, q, true}, [first, p](const auto& x, auto out) {
      for (Eigen::Index j = 0; j < x.cols(); ++j) {
        out.col(2 * j) = x.col(j).segment(first, p);
        out.col(2 * j + 1) = x.col(j).segment(first + p, p);
      }
    });
  observables.all_invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    const Eigen::MatrixXcd Q = complex_block(x, 0, p), P = complex_block(x, 2 * p, p);
    if (out.wants(family::hamiltonian)) {
      const double H = double_bracket_hamiltonian<double>(lambda_u, lambda_v, Q, P);
      // √H is a norm of PQ† − QP† and P†Q − Q†P; of_terms is the norm of the products in these
      // differences.
      const double least = std::min(lambda_u.minCoeff(), lambda_v.minCoeff());
      const long double of_terms = Q.stableNorm() * P.stableNorm() / std::sqrt(8 * least);
      const bool at_rest = is_rounding(std::sqrt(H), static_cast<double>(of_terms));
      out.add(family::hamiltonian, H, at_rest ? of_terms * of_terms : H);
    }
    const std::pair<Complex, Complex> combinations[] = {{1, 0}, {0, 1}, {1, 1}, {1, {0, 1}}};
    if (!out.wants(family::singular_values)) return;
    double largest[2] = {0, 0};  // ‖Q‖ and ‖P‖
    for (int c = 0; c < 4; ++c) {
      const auto [a, b] = combinations[c];
      const Eigen::VectorXd s = singular_values(Q, P, a, b);
      if (c < 2) largest[c] = s(0);
      // Q + P may be small, or 0; its singular values change by the rounding of Q and P, so the
      // scale is that of Q and P.
      const double scale = std::abs(a) * largest[0] + std::abs(b) * largest[1];
      for (Eigen::Index i = 0; i < s.size(); ++i)
        out.add(family::singular_values, indexed(family::singular_values, c, i), s(i), scale);
    }
  };
  stop_point();
  // Shared by the copies of the observables: its workspace has tens of megabytes where p + q = 512.
  const auto system = std::make_shared<DoubleBracket<double>>(lambda_u, lambda_v);
  observables.speed = [system, p, q](const Eigen::MatrixXd& x) {
    auto xi = system->zero();
    system->generator(x, xi);
    if (!xi.allFinite()) return std::numeric_limits<double>::infinity();
    const double U = skew_norm<double>(xi.topLeftCorner(2 * p, 2 * p));
    stop_point();
    return std::max(U, skew_norm<double>(xi.bottomRightCorner(2 * q, 2 * q)));
  };
  stop_point();
  return make_simulation(scene, *system, shared(observables));
}

}  // namespace

Vector<double> singular_values(const Matrix<std::complex<double>>& Q,
                               const Matrix<std::complex<double>>& P, std::complex<double> a,
                               std::complex<double> b) {
  const Matrix<std::complex<double>> Z = a * Q + b * P;
  const Matrix<double> X = Z.real().transpose(), Y = Z.imag().transpose();
  const Eigen::Index p = Z.rows(), q = Z.cols();
  // [[0, R], [Rᵀ, 0]] with Z as a real matrix R = [[Re Z, −Im Z], [Im Z, Re Z]].
  Matrix<double> S = Matrix<double>::Zero(2 * (p + q), 2 * (p + q));
  S.bottomLeftCorner(2 * q, 2 * p) << X, Y, -Y, X;
  const Vector<double> w = symmetric_eigenvalues(S);
  Vector<double> values(std::min(p, q));
  for (Eigen::Index k = 0; k < values.size(); ++k) values(k) = w(w.size() - 1 - 2 * k);
  return values;
}

SystemEntry double_bracket_entry() {
  SystemInfo info{};
  info.blocks = {{"Q", "p x q, complex", true, ""}, {"P", "p x q, complex", true, ""}};
  info.fields = {{"Q", "p x q, complex", ""}, {"P", "p x q, complex", ""}};
  info.invariants = {
      {family::hamiltonian,
       "1/4 <U, J_U U> + 1/4 <V, J_V V>, <A, B> = 1/2 tr(A^+ B), J_U U = Lambda_U U + U Lambda_U, "
       "J_V V = Lambda_V V + V Lambda_V",
       "[RB] (5.6)"},
      {family::singular_values,
       "[c, k]: the k-th singular value of Q, P, Q + P and Q + i P for c = 0 to 3",
       "[RB] section 5"},
  };
  info.name = "double_bracket";
  info.summary = "coupled double bracket on U(p) x U(q); its limits are the rigid bodies";
  info.equations =
      "Q' = U Q - Q V, P' = U P - P V, U = J_U^-1(P Q^+ - Q P^+), V = J_V^-1(P^+ Q - Q^+ P)";
  info.source = "[RB] (5.6)-(5.11)";
  info.file = "engine/bracket/double_bracket.h";
  return {.info = info,
          .check = check_double_bracket,
          .make = make_double_bracket,
          .methods = methods_on<DoubleBracket<double>>,
          .recommended = for_double_bracket,
          .motion = &in_both<double_bracket_equations, double_bracket_start>,
          .size = size};
}

}  // namespace stiefel
