#include "stiefel/diagnosis.h"

#include <algorithm>

#include "engine/motion/system_entry.h"
#include "engine/motion/two_form.h"
#include "engine/scene/near_name.h"
#include "engine/scene/scene_draft.h"
#include "engine/structure/dirac_bracket.h"
#include "engine/structure/symplectic_defect.h"
#include "engine/structure/tangent_spaces.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

constexpr double tangency = 1e-8;

Dense state_of(const TwoForm& form, const Simulation& now) {
  return stacked_pair<double>(now.get(form.blocks[0]), now.get(form.blocks[1]));
}

/// After so many violations of one bracket the others are not looked for.
constexpr std::size_t most_refused_factors = 64;

/// Describes the shape of a block and its faults: "3 x 4, complex, not finite".
std::string value_of(const Block& block) {
  return shape_text(block.values.rows(), block.values.cols()) +
         (block.imaginary.size() > 0 ? ", complex" : "") +
         (block.values.allFinite() ? "" : ", not finite");
}

/// Stacks the named blocks of a tangent vector. Returns an empty matrix and adds violations if they
/// do not have the shapes of the state's blocks.
Dense stacked_vector(const std::string& field, const TangentVector& u,
                     const std::array<std::string_view, 2>& names, const Dense& x,
                     Violations& violations) {
  const Eigen::Index rows = x.rows() / 2;
  Dense out(x.rows(), x.cols());
  const std::string name[] = {std::string(names[0]), std::string(names[1])};
  for (int k = 0; k < 2; ++k) {
    const auto found = u.find(name[k]);
    const bool fits = found != u.end() && found->second.values.rows() == rows &&
                      found->second.values.cols() == x.cols() &&
                      found->second.imaginary.size() == 0;
    if (!fits || !found->second.values.allFinite()) {
      violations.push_back(
          Violation{field + "." + name[k], found == u.end() ? "absent" : value_of(found->second),
                    "must be given, real, finite and " + shape_text(rows, x.cols())});
      continue;
    }
    out.middleRows(k * rows, rows) = found->second.values;
  }
  for (const auto& [other, block] : u)
    if (other != name[0] && other != name[1])
      violations.push_back(
          Violation{field + "." + other, value_of(block),
                    "the blocks are " + name[0] + ", " + name[1] + did_you_mean(other, names)});
  return out;
}

std::unexpected<Violations> refuse_ensemble(const Scene& scene) {
  return std::unexpected(
      Violations{Violation{"", std::to_string(scene.members().size()) + " members",
                           "the scene must have no `members`: two-forms and brackets are "
                           "evaluated for single scenes"}});
}

/// Whether the scene has the blocks that the form reads; a body may have no frame.
bool has_blocks(const Simulation& now, const TwoForm& form) {
  return std::ranges::all_of(form.blocks, [&](std::string_view name) {
    return std::ranges::find(now.fields(), name, &Field::name) != now.fields().end();
  });
}

const std::vector<const TwoForm*>& two_forms_of(const Scene& scene) {
  return system_entry(scene.system())->two_forms;
}

/// Returns (QR, RᵀMR) for a body whose caller uses other axes than the principal ones.
Dense in_principal_axes(const Scene& scene, Dense x) {
  if (!scene.axes()) return x;
  const Dense R = scene.axes()->rotation;
  x = (x * R).eval();
  x.bottomRows(3) = (R.transpose() * x.bottomRows(3)).eval();
  return x;
}

}  // namespace

std::expected<double, Violations> evaluate_form(const Scene& scene, const Simulation& now,
                                                const std::string& form, const TangentVector& u,
                                                const TangentVector& v) {
  if (!scene.members().empty()) return refuse_ensemble(scene);
  const auto& has = two_forms_of(scene);
  const auto found = std::ranges::find_if(has, [&](auto* s) { return s->info.name == form; });
  if (found == has.end() || !has_blocks(now, **found))
    return std::unexpected(
        Violations{Violation{"form", form,
                             "is not a two-form of " + scene.system() +
                                 did_you_mean(form, has, [](auto* s) { return s->info.name; })}});
  const FormSpace space = (*found)->space(scene);
  const Dense x = state_of(**found, now);
  Violations violations;
  const auto read = [&](const char* field, const TangentVector& given) {
    const std::size_t before = violations.size();
    const Dense w = stacked_vector(field, given, (*found)->info.blocks, x, violations);
    if (violations.size() > before) return w;
    const double off = (space.tangent(x, w) - w).norm();
    if (!(off <= tangency * w.norm()))
      violations.push_back(Violation{field,
                                     "off by " + to_text(off) + " at norm " + to_text(w.norm()),
                                     "must be tangent to " + to_text(tangency) + " of its norm"});
    return w;
  };
  const Dense first = read("first", u), second = read("second", v);
  if (!violations.empty()) return std::unexpected(std::move(violations));
  return space.form(x, first, second);
}

std::expected<std::optional<double>, Violations> symplectic_defect(const Scene& scene,
                                                                   const Simulation& now, int pairs,
                                                                   unsigned seed,
                                                                   const std::stop_token& stop) {
  if (!scene.members().empty()) return refuse_ensemble(scene);
  const auto& has = two_forms_of(scene);
  if (has.empty() || !has_blocks(now, *has.front()))
    return std::unexpected(Violations{Violation{"", scene.system(), "has no two-form"}});
  return unless_stopped(stop,
                        [&] {
                          const auto map = make_simulation(scene);
                          const auto phi = [&](const Dense& x) {
                            stop_point();
                            return map->image(x);
                          };
                          const Dense x = in_principal_axes(scene, state_of(*has.front(), now));
                          return symplectic_defect<double>(has.front()->space(scene), phi, x, pairs,
                                                           seed);
                        })
      .value_or(std::nullopt);
}

Jet jet_of(const PairFactors& function, const Matrix<double>& Q, const Matrix<double>& P) {
  Jet jet{1, Matrix<double>::Zero(Q.rows(), Q.cols()), Matrix<double>::Zero(Q.rows(), Q.cols())};
  for (const auto& [A, B] : function.factors) {
    stop_point(6 * static_cast<double>(Q.size()));
    const double f = trace_product(A, Q) + trace_product(B, P);
    jet.by_Q = f * jet.by_Q + 2 * jet.value * A;
    jet.by_P = f * jet.by_P + 2 * jet.value * B;
    jet.value *= f;
  }
  return jet;
}

double dirac_bracket(const Matrix<double>& Q, const Matrix<double>& P, const PairFactors& F,
                     const PairFactors& K) {
  const auto f = jet_of(F, Q, P), k = jet_of(K, Q, P);
  const auto inner = [](const Matrix<double>& X, const Matrix<double>& Y) {
    return trace_product(X, Y) / 2;
  };
  const auto twice_symmetric = [](const Matrix<double>& X) -> Matrix<double> {
    stop_point(2 * static_cast<double>(X.rows() * X.size()));
    return X + X.transpose();
  };
  const Matrix<double> R = Q * P.transpose();
  // (I + R ⊗ Rᵀ)⁻¹ of [RB] (3.15): R is orthogonal, so Y + RYR = RG is RᵀY + YR = G.
  Lyapunov<double> equation(R.rows());
  equation.factor(R);
  const auto solve = [&](const Matrix<double>& G) {
    Matrix<double> Y(G.rows(), G.cols());
    equation.solve(G, Y);
    return Y;
  };
  return inner(k.by_P, f.by_Q) - inner(k.by_Q, f.by_P) -
         inner(twice_symmetric(k.by_P * Q.transpose()),
               solve(twice_symmetric(f.by_Q * P.transpose()))) /
             2 +
         inner(twice_symmetric(k.by_Q * P.transpose()),
               solve(R.transpose() * twice_symmetric(f.by_P * Q.transpose()) * R)) /
             2;
}

std::expected<double, Violations> dirac_bracket(const Scene& scene, const Simulation& now,
                                                const PairFactors& F, const PairFactors& K) {
  if (!scene.members().empty()) return refuse_ensemble(scene);
  const int N = scene.dimension();
  Violations violations;
  if (!system_entry(scene.system())->dirac_bracket)
    violations.push_back(Violation{
        "", scene.system(),
        "has no Dirac bracket; symmetric_rigid_body and symmetric_moser_veselov have one"});
  const auto check = [&](const std::string& field, const PairFactors& given) {
    for (std::size_t k = 0; k < given.factors.size() && violations.size() < most_refused_factors;
         ++k) {
      const auto& [A, B] = given.factors[k];
      for (const auto& [name, matrix] : {std::pair(".A", &A), std::pair(".B", &B)})
        if (matrix->rows() != N || matrix->cols() != N || !matrix->allFinite())
          violations.push_back(Violation{field + "[" + std::to_string(k) + "]" + name,
                                         value_of(*matrix),
                                         "must be finite and " + shape_text(N, N)});
    }
  };
  check("first", F), check("second", K);
  if (!violations.empty()) return std::unexpected(std::move(violations));
  return dirac_bracket(now.get("Q"), now.get("P"), F, K);
}

}  // namespace stiefel
