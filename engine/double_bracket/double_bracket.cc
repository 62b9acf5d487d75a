#include <array>
#include <cmath>

#include "engine/catalogue/series_start.h"
#include "engine/catalogue/system_entry.h"
#include "engine/scene/scene_draft.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

extern const SeriesEquations double_bracket_equations;

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

void check(SceneDraft& draft) {
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

constexpr auto start = [](const auto& g) {
  const auto vector = [&](const std::vector<double>& l) {
    return g.numbers(
        Eigen::Map<const Eigen::VectorXd>(l.data(), static_cast<Eigen::Index>(l.size())));
  };
  auto made = g.start(g.block("Q"), g.block("P"));
  made.lambda = vector(g.scene.description().inertia_u);
  made.lambda_v = vector(g.scene.description().inertia_v);
  made.presentation.complex = true;
  return made;
};

bool of_scalars(const Scene& scene) {
  return scene.description().inertia_u.size() == 1 && scene.description().inertia_v.size() == 1;
}

constexpr std::array recommendations = {
    // U and V are constant, so a step by the exponential is exact.
    Recommendation{
        .where = "1 x 1 blocks", .takes = of_scalars, .method = "munthe_kaas4", .order = 4},
    with_error_control(1e-13)};

FrameSize size(const Scene& scene) {
  const SceneDescription& given = scene.description();
  return {static_cast<double>(given.inertia_u.size()), static_cast<double>(given.inertia_v.size())};
}

}  // namespace

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
  info.file = "engine/double_bracket/double_bracket.h";
  return {.info = info,
          .check = check,
          .recommended = recommendations,
          .motion = &in_both<double_bracket_equations, start>,
          .size = size};
}

}  // namespace stiefel
