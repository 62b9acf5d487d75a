#include "engine/rigid_body/parametric/parametric_forms.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {
namespace {

WithinDomain<Expression> write(const Phase& x, const ConversionTarget& target, Margins& margins) {
  return write_parametric(x.step, x, target, margins);
}
constexpr Representation representation = {.square = true,
                                           .read = read_parametric,
                                           .write = write,
                                           .has_epsilon = true,
                                           .has_parameter = true};

}  // namespace

SystemEntry parametric_moser_veselov_entry() {
  SystemInfo info = parametric_info("M = (Q^-1 P - P^-1 Q) / epsilon - mu Lambda^2 / h, skew");
  info.name = "parametric_moser_veselov";
  info.summary = "discrete rigid body in GL(N) with the spectral parameter mu";
  info.equations =
      "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k (U + mu Lambda), P_{k+1} = P_k (U + mu Lambda)";
  info.source = "[RB] (8.10)-(8.11)";
  info.file = "engine/rigid_body/parametric/parametric_moser_veselov.h";
  info.discrete = true;
  return {.info = info,
          .check = [](SceneDraft& draft) { check_parametric(draft, draft.step()); },
          .representation = &representation};
}

}  // namespace stiefel
