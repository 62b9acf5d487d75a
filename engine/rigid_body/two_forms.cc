#include "engine/rigid_body/two_forms.h"

#include "engine/laws/tangent_spaces.h"
#include "engine/frames/body/stiefel_momenta.h"
#include "engine/catalogue/forms.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

template <class S>
FormSpace space_of(S of) {
  return {[of](const Dense& x, const Dense& G) { return of.tangent(x, G); },
          [of](const Dense& x, const Dense& u, const Dense& v) { return of.form(x, u, v); }};
}

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

}  // namespace

namespace two_form {

constinit const TwoForm of_bodies = {
    {"omega",
     {"Q", "M"},
     "<Z_2, xi_1> - <Z_1, xi_2> + <M, [xi_1, xi_2]> of (Q xi_i, Z_i), <A, B> = -1/2 tr(A B)",
     "[RB] (3.13)"},
    {"Q", "M"},
    [](const Scene&) { return space_of(CotangentOfRotations<double>()); }};
constinit const TwoForm of_symmetric_pairs = {
    {"Omega_gl", {"Q", "P"}, "1/2 tr(eta_2^T xi_1 - eta_1^T xi_2) of (xi_i, eta_i)", "[RB] (3.5)"},
    {"Q", "P"},
    [](const Scene&) { return space_of(PairsOfRotations<double>()); }};
constinit const TwoForm of_two_frames = {
    {"Omega_L",
     {"Q_prev", "Q"},
     "1/2 tr(u_1 Lambda v_2^T - v_1 Lambda u_2^T) of u = (u_1, u_2), v = (v_1, v_2)",
     "[RB] (7.8)"},
    {"Q_prev", "Q"},
    [](const Scene& s) { return space_of(ConsecutiveRotations<double>{s.inertia()}); }};
constinit const TwoForm of_tangent_pairs = {
    {"omega_pairs",
     {"Q", "S"},
     "tr(u_1^T v_2) - tr(u_2^T v_1) of u = (u_1, u_2), v = (v_1, v_2)",
     "[ST] (63)"},
    {"Q", "S"},
    [](const Scene& s) { return space_of(CotangentOfFrames<double>{s.inertia()}); }};
constinit const TwoForm of_costate_pairs = {
    {"omega_pairs",
     {"Q", "P"},
     "tr(u_1^T v_2) - tr(u_2^T v_1) of u = (u_1, u_2), v = (v_1, v_2)",
     "[ST] (63), (71)"},
    {"Q", "P"},
    [](const Scene&) { return space_of(CostatesOfFrames<double>()); }};
constinit const TwoForm of_cotangent_pairs = {
    {"omega_cotangent",
     {"QU", "QZ"},
     "<Q U_2 W + Q Z_2, Q U_1> - <Q U_1 W + Q Z_1, Q U_2> of (Q U_i, Q Z_i), <A, B> = tr(A^T "
     "B), "
     "W = Q^T R - R^T Q, R = S (I - 1/2 Q^T Q)",
     "[ST] (93)"},
    {"Q", "S"},
    [](const Scene&) { return space_of(CotangentPairs()); }};

}  // namespace two_form

}  // namespace stiefel
