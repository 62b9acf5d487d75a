#include "engine/simulation/structure.h"

#include <algorithm>

#include "engine/invariants/dirac_bracket.h"
#include "engine/invariants/symplectic_defect.h"
#include "engine/invariants/tangent_spaces.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/two_forms.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

constexpr double tangency = 1e-8;

Dense state_of(const TwoForm& form, const Simulation& now) {
  return stacked_pair<double>(now.get(form.blocks[0]), now.get(form.blocks[1]));
}

/// Stacks the blocks of these names; empty with a violation if they are not as the state's.
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
      violations.push_back({field + "." + name[k], found == u.end() ? "absent" : "",
                            "must be there, real, finite and " + std::to_string(rows) + " x " +
                                std::to_string(x.cols())});
      continue;
    }
    out.middleRows(k * rows, rows) = found->second.values;
  }
  for (const auto& [other, block] : u)
    if (other != name[0] && other != name[1])
      violations.push_back({field + "." + other, "", "the blocks are " + name[0] + ", " + name[1]});
  return out;
}

std::unexpected<Violations> refuse_ensemble(const Scene& scene) {
  return std::unexpected(Violations{{"members", std::to_string(scene.members().size()),
                                     "two-forms and brackets are of single scenes"}});
}

/// Those may be without a frame.
bool is_rigid_body(const Scene& scene) {
  return scene.system() == "rigid_body" || scene.system() == "moser_veselov";
}

/// (QR, RᵀMR) for a body that is told in other axes.
Dense in_principal_axes(const Scene& scene, Dense x) {
  if (!scene.axes()) return x;
  const Dense R = scene.axes()->rotation;
  x = (x * R).eval();
  x.bottomRows(3) = (R.transpose() * x.bottomRows(3)).eval();
  return x;
}

}  // namespace

std::vector<FormInfo> forms_of(std::string_view system) {
  std::vector<FormInfo> forms;
  for (const TwoForm* form : two_forms_of(system)) forms.push_back(form->info);
  return forms;
}

std::expected<double, Violations> evaluate_form(const Scene& scene, const Simulation& now,
                                                const std::string& form, const TangentVector& u,
                                                const TangentVector& v) {
  if (!scene.members().empty()) return refuse_ensemble(scene);
  const auto has = two_forms_of(scene.system());
  const auto found = std::ranges::find_if(has, [&](auto* s) { return s->info.name == form; });
  if (found == has.end() || (is_rigid_body(scene) && !scene.has_frame()))
    return std::unexpected(Violations{{"form", form, "is not a form of " + scene.system()}});
  const FormSpace space = (*found)->space(scene);
  const Dense x = state_of(**found, now);
  Violations violations;
  const auto read = [&](const char* field, const TangentVector& given) {
    const std::size_t before = violations.size();
    const Dense w = stacked_vector(field, given, (*found)->info.blocks, x, violations);
    if (violations.size() > before) return w;
    const double off = (space.tangent(x, w) - w).norm();
    if (!(off <= tangency * w.norm()))
      violations.push_back({field, "off by " + std::to_string(off), "must be tangent"});
    return w;
  };
  const Dense first = read("first", u), second = read("second", v);
  if (!violations.empty()) return std::unexpected(std::move(violations));
  return space.form(x, first, second);
}

std::expected<std::optional<double>, Violations> symplectic_defect(const Scene& scene,
                                                                   const Simulation& now, int pairs,
                                                                   unsigned seed) {
  if (!scene.members().empty()) return refuse_ensemble(scene);
  const auto has = two_forms_of(scene.system());
  const bool no_frame = is_rigid_body(scene) && !scene.has_frame();
  if (has.empty() || no_frame)
    return std::unexpected(
        Violations{{"symplectic_test", scene.system(), "this system's states have no two-form"}});
  const auto map = make_simulation(scene);
  const auto phi = [&](const Dense& x) { return map->image(x); };
  const Dense x = in_principal_axes(scene, state_of(*has.front(), now));
  return symplectic_defect<double>(has.front()->space(scene), phi, x, pairs, seed);
}

std::expected<double, Violations> dirac_bracket(const Scene& scene, const Simulation& now,
                                                const PairFactors& F, const PairFactors& K) {
  if (!scene.members().empty()) return refuse_ensemble(scene);
  const int N = scene.dimension();
  Violations violations;
  if (scene.system() != "symmetric_rigid_body" && scene.system() != "symmetric_moser_veselov")
    violations.push_back({"system", scene.system(), "must be a symmetric rigid body, (Q, P)"});
  const auto function = [&](const char* field, const PairFactors& given) {
    PairFunction out;
    for (const auto& [A, B] : given.factors) {
      for (const RowMatrix* matrix : {&A, &B})
        if (matrix->rows() != N || matrix->cols() != N || !matrix->allFinite())
          violations.push_back(
              {field, std::to_string(matrix->rows()) + " x " + std::to_string(matrix->cols()),
               "A and B must be finite and N x N"});
      out.factors.push_back({A, B});
    }
    return out;
  };
  const PairFunction first = function("first", F), second = function("second", K);
  if (!violations.empty()) return std::unexpected(std::move(violations));
  return dirac_bracket(now.get("Q"), now.get("P"), first, second);
}

}  // namespace stiefel
