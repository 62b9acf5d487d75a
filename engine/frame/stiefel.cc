#include "engine/dense/decompositions.h"
#include "engine/frame/stiefel_forms.h"
#include "engine/frame/stiefel_maps.h"
#include "engine/motion/make_simulation.h"
#include "engine/motion/two_form.h"
#include "engine/structure/tangent_spaces.h"
#include "stiefel/stop.h"

namespace stiefel {

template class FramePass<double>;
template class RattleStiefel<double>;
template class SimulationOf<Composition<RattleStiefel<double>>>;

namespace {

void check_stiefel(SceneDraft& draft) {
  if (check_stiefel_frame(draft)) set_tangent(draft, "Q", "S", false);
}

WithinDomain<Phase> read_stiefel(const Scene& scene, Margins&) {
  Phase x = phase_of_costate(scene, scene.Q(), scene.block("S"));
  if (!x.square()) x.S = scene.block("S");
  return x;
}
WithinDomain<FormBlocks> write_stiefel(const Phase& x, const ConversionTarget&, Margins&) {
  return FormBlocks{{{"Q", x.Q}, {"S", S_of(x)}}};
}
constexpr Representation stiefel_representation = {false, read_stiefel, write_stiefel};

constexpr auto stiefel_start = [](const auto& g) { return g.start(g.block("Q"), g.block("S")); };

constexpr TwoForm form_of_stiefel = {
    {"omega_pairs",
     {"Q", "S"},
     "tr(u_1^T v_2) - tr(u_2^T v_1) of u = (u_1, u_2), v = (v_1, v_2)",
     "[ST] (63)"},
    {"Q", "S"},
    [](const Scene& s) { return space_of(CotangentOfFrames<double>{s.inertia()}); }};

/// Pairs (Q, S̄) with tangent vectors (QU, QZ), [ST] (93).
struct CotangentPairs {
  Dense tangent(const Dense& x, const Dense& G) const {
    const Eigen::Index n = x.rows() / 2;
    const Dense Q = x.topRows(n);
    return stacked_pair<double>(tangent_to_frames<double>(Q, G.topRows(n)),
                                tangent_to_frames<double>(Q, G.bottomRows(n)));
  }
  double form(const Dense& x, const Dense& u, const Dense& v) const {
    const Eigen::Index n = x.rows() / 2;
    const Dense Q = x.topRows(n), S = x.bottomRows(n);
    return omega_cotangent<double>(stacked_pair<double>(Q, S_bar(Q, S)), u, v);
  }
};
constexpr TwoForm form_of_cotangent_pairs = {
    {"omega_cotangent",
     {"QU", "QZ"},
     "<Q U_2 W + Q Z_2, Q U_1> - <Q U_1 W + Q Z_1, Q U_2> of (Q U_i, Q Z_i), <A, B> = tr(A^T "
     "B), "
     "W = Q^T R - R^T Q, R = S (I - 1/2 Q^T Q)",
     "[ST] (93)"},
    {"Q", "S"},
    [](const Scene&) { return space_of(CotangentPairs()); }};

bool is_isotropic(const Scene& scene) {
  return (scene.inertia().array() == scene.inertia()(0)).all();
}
bool in_the_plane(const Scene& scene) { return scene.dimension() == 2; }
Eigen::Index rows(const Scene& scene) { return scene.block("Q").rows(); }
bool has_whole_attitude(const Scene& scene) { return rows(scene) >= scene.dimension() - 1; }

bool has_four_dimensions(const Scene& scene) { return scene.dimension() == 4; }

// With 1 < n < N - 1 most motions are chaotic: their condition is 1e6 and more after 100 rotations,
// and a larger tolerance suffices to keep the error below 1e-8 times the condition. A few, mostly
// in four dimensions, have a condition of only 100; for N > 4 the bound on the step suffices for
// them.
constexpr std::array for_stiefel = {
    Recommendation{.where = "Lambda a multiple of the identity",
                   .takes = is_isotropic,
                   .method = "exact",
                   .arithmetic = "compensated"},
    restricted("N = 2", in_the_plane, with_error_control(2e-13, 0.12)),
    restricted("n >= N - 1", has_whole_attitude, with_error_control(5e-14, 0.12)),
    restricted("n = 1", is_one_point, with_error_control(5e-13, 0.15)),
    restricted("N = 4", has_four_dimensions, with_error_control(5e-13, 0.15)),
    with_error_control(2e-12, 0.14)};

std::unique_ptr<Simulation> make_stiefel(const Scene& scene) {
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  Observables observables(stacked(scene, "Q", "S"));
  observables.block("Q", 0, static_cast<int>(n));
  observables.block("S", static_cast<int>(n), static_cast<int>(n));
  report_geodesic(observables, {scene.inertia(), n, false});
  if (N <= largest_written_M)
    observables.field(
        {"M", static_cast<int>(N), static_cast<int>(N)},
        [n](const auto& x, auto out) { out = dense_M<double>(x.topRows(n), x.bottomRows(n)); });
  return make_simulation<Variational, Exact>(scene, Stiefel<double>(scene.inertia(), n),
                                             shared(std::move(observables)));
}

/// QQᵀ = I, any lower block.
Dense tangent_to_costates(const Dense& x, const Dense& G) {
  Dense T = G;
  const Index n = x.rows() / 2;
  T.topRows(n) = tangent_to_frames<double>(x.topRows(n), G.topRows(n));
  return T;
}

/// A scene makes S tangent: QΛ⁻¹Sᵀ + SΛ⁻¹Qᵀ = 0 for S − YQ, so that dS = −dY Q with
///
///     K dY + dY K = −(C + Cᵀ),   C = Q (dΛ/Λ²) Sᵀ,   K = QΛ⁻¹Qᵀ.
Dense frames_by_inertia(const Eigen::VectorXd& lambda, const Dense& x) {
  const Index n = x.rows() / 2;
  const auto Q = x.topRows(n), S = x.bottomRows(n);
  SymmetricLyapunov<double> lyapunov(n);
  lyapunov.factor(Q * lambda.cwiseInverse().asDiagonal() * Q.transpose());
  Dense out = Dense::Zero(x.size(), x.cols()), dY(n, n);
  for (Index k = 0; k < x.cols(); ++k) {
    stop_point(2 * static_cast<double>(n * Q.size()));
    const Dense C = Q.col(k) * S.col(k).transpose() / (lambda(k) * lambda(k));
    lyapunov.solve(-(C + C.transpose()), dY);
    out.col(k).reshaped(x.rows(), x.cols()).bottomRows(n) = -dY * Q;
  }
  return out;
}

TangentSpace cotangent_of_frames(const Scene& scene) {
  const CotangentOfFrames<double> frames{scene.inertia()};
  return {[frames](const Dense& x, const Dense& G) { return frames.tangent(x, G); },
          tangent_to_costates,
          [lambda = frames.lambda](const Dense& x) { return frames_by_inertia(lambda, x); }};
}

constexpr MethodTangent tangent_of_variational[] = {{method_name::variational, rattle_tangent}};
constexpr Tangents stiefel_tangents = {cotangent_of_frames, tangent_of_variational};

}  // namespace

SystemEntry stiefel_entry() {
  SystemInfo info = stiefel_info({"S", "n x N", true, "S = Q' Lambda"});
  info.fields.push_back({"M", "N x N", "M = Q^T S - S^T Q, N <= 4096"});
  info.name = "stiefel";
  info.summary = "geodesics on the Stiefel manifold V(n, N) with the metric of Lambda";
  info.equations = "Q' = S Lambda^-1, S' = B Q, K B + B K = -2 Q' Q'^T, K = Q Lambda^-1 Q^T";
  info.source = "[ST] (37)-(39)";
  info.file = "engine/frame/stiefel.h";
  return {.info = info,
          .check = check_stiefel,
          .make = make_stiefel,
          .methods = methods_on<Stiefel<double>, Variational, Exact>,
          .recommended = for_stiefel,
          .two_forms = {&form_of_stiefel, &form_of_cotangent_pairs},
          .representation = &stiefel_representation,
          .tangents = &stiefel_tangents,
          .motion = &in_both<frame_equations, stiefel_start>,
          .rate = Rate::frame_speed};
}

}  // namespace stiefel
