#include <cmath>

#include "engine/catalogue/system_entry.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {

namespace {

void check(SceneDraft& draft) {
  draft.refuse_other_numbers();
  draft.refuse_if(draft.given().body.has_value(), "body");
  draft.check_block_names();
  if (!draft.set_inertia()) return;
  const Eigen::Index N = draft.scene().dimension();
  const RowMatrix* H = draft.block("H", N, N);
  if (H == nullptr || !draft.check_size("initial.H", "max |H|", H->cwiseAbs().maxCoeff())) return;
  const double defect = (*H - H->transpose()).cwiseAbs().maxCoeff();
  if (!(defect <= draft.largest_repair() * H->cwiseAbs().maxCoeff()))
    return draft.refuse("initial.H", "max |H - Hᵀ| = " + to_text(defect), "must be symmetric");
  draft.set_block("H", (*H + H->transpose()) / 2);
}

SceneDescription example(unsigned seed) {
  SceneDescription d;
  d.inertia = {4, 3, 2, 1};
  RowMatrix H(4, 4);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j <= i; ++j) H(i, j) = H(j, i) = std::sin(seed + 3.0 * i + 5.0 * j * j);
  d.initial["H"] = H / 2;
  return d;
}

}  // namespace

SystemEntry brockett_entry() {
  SystemInfo info{};
  info.name = "brockett";
  info.summary = "Brockett's flow of symmetric matrices to diagonal ones";
  info.equations = "H' = [[D, H], H], D = diag(inertia)";
  info.source = "Brockett 1991";
  info.file = "tests/support/toys/brockett_simulation.cc";
  info.blocks = {{"H", "N x N", true, "symmetric"}};
  info.fields = {{"H", "N x N", "symmetric"}};
  info.invariants = {{"eigenvalues", "of H, ascending", "Brockett 1991"}};
  return {.info = info, .check = check, .example = example};
}

}  // namespace stiefel
