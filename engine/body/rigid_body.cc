#include "engine/body/rigid_body_data.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "engine/body/exact/turned_body.h"
#include "engine/body/rigid_body.h"
#include "engine/body/rigid_forms.h"
#include "engine/body/rigid_tangents.h"
#include "engine/dense/principal_moments_3.h"
#include "engine/dense/so_3.h"
#include "engine/motion/body_view.h"
#include "engine/motion/method_entry.h"
#include "engine/motion/representation.h"
#include "engine/motion/series_start.h"
#include "engine/motion/system_entry.h"
#include "engine/motion/two_form.h"
#include "engine/scene/given_body.h"
#include "engine/structure/tangent_spaces.h"

namespace stiefel {
namespace {

std::string list_text(std::span<const double> list) {
  return list.empty() ? "absent" : to_text(list);
}

/// Returns the principal axes of an inertia tensor or of moments; adds violations if they are
/// invalid.
PrincipalAxes check_moments(SceneDraft& draft, const GivenBody& body) {
  // A draft that starts from a scene with these moments has their axes.
  if (const auto& known = draft.scene().axes()) {
    const BodyDescription& first = *draft.given().body;
    const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
    if (std::ranges::equal(first.moments, body.moments, {}, bits, bits) &&
        std::ranges::equal(first.inertia_tensor, body.tensor, {}, bits, bits))
      return *known;
  }
  const bool tensor = !body.tensor.empty();
  if (tensor == !body.moments.empty()) {
    draft.refuse("body",
                 tensor ? "inertia_tensor and moments" : "neither inertia_tensor nor moments",
                 "needs exactly one of inertia_tensor and moments");
    return {};
  }
  const std::string_view field = tensor ? "body.inertia_tensor" : "body.moments";
  const auto given = tensor ? body.tensor : body.moments;
  if (given.size() != (tensor ? 6u : 3u)) {
    draft.refuse(
        field, to_text(given),
        tensor ? "must have 6 numbers: Ixx, Iyy, Izz, Ixy, Ixz, Iyz" : "must have 3 numbers");
    return {};
  }
  if (!draft.all_finite(field, given)) return {};
  const auto [moments, rotation] = given_axes<double>(body);
  const PrincipalAxes axes{moments, rotation};
  if (!(axes.moments.minCoeff() > 0))
    draft.refuse(field, "smallest principal moment " + to_text(axes.moments.minCoeff()),
                 "every principal moment must be > 0");
  else if (draft.check_number(field, "the smallest moment", axes.moments.minCoeff()))
    draft.check_number(field, "the largest moment", axes.moments.maxCoeff());
  return axes;
}

/// Checks a body and returns it in its principal axes; adds violations if it is invalid.
std::optional<Body3> body_of(SceneDraft& draft, const GivenBody& body) {
  const PrincipalAxes axes = check_moments(draft, body);
  if (body.angular_velocity.size() != 3)
    draft.refuse("body.angular_velocity", list_text(body.angular_velocity), "must have 3 numbers");
  else
    draft.all_finite("body.angular_velocity", body.angular_velocity);
  if (body.attitude.size() != 4)
    draft.refuse("body.attitude", to_text(body.attitude), "must have 4 numbers: w, x, y, z");
  else if (draft.all_finite("body.attitude", body.attitude)) {
    const double norm = Eigen::Vector4d(body.attitude.data()).stableNorm();
    if (!(std::abs(norm - 1) <= draft.largest_repair()))
      draft.refuse("body.attitude", to_text(body.attitude) + " of norm " + to_text(norm),
                   "must have norm 1 to " + to_text(draft.largest_repair()));
  }
  if (!draft.sound()) return std::nullopt;

  const Eigen::Vector3d given_omega(body.angular_velocity.data());
  if (!draft.check_velocity("body.angular_velocity", "max |ω|", given_omega.cwiseAbs().maxCoeff()))
    return std::nullopt;
  const Eigen::Matrix3d& R = axes.rotation;
  const Eigen::Vector3d omega = R.transpose() * given_omega;
  Eigen::Matrix<double, 7, 1> q = Eigen::Matrix<double, 7, 1>::Zero();
  q.head<4>() = Eigen::Vector4d(body.attitude.data()).normalized();
  const Eigen::Vector3d m = axes.moments.cwiseProduct(omega);
  if (!draft.check_size("body.angular_velocity", "max |Iω|", m.cwiseAbs().maxCoeff()))
    return std::nullopt;
  const Eigen::Vector4d r = quaternion_of(R);
  return Body3{.lambda = inertia_of_moments(axes.moments),
               .m = m,
               .attitude = So3<double, true>::quaternion_times(q, r(0), r.tail<3>()),
               .axes = axes};
}

void check_body(SceneDraft& draft) {
  auto& body = *draft.given().body;
  if (!draft.given().inertia.empty())
    draft.refuse("inertia", to_text(draft.given().inertia), "must be absent when `body` is given");
  if (!draft.given().initial.empty())
    draft.refuse("initial", std::to_string(draft.given().initial.size()) + " blocks",
                 "must be absent when `body` is given");
  if (body.attitude.empty()) body.attitude = {1, 0, 0, 0};
  if (const auto checked = body_of(draft, GivenBody(body))) draft.set_body(*checked);
}

void check_momentum_or_body(SceneDraft& draft) {
  const SceneDescription& given = draft.given();
  if (!given.body && given.inertia.empty() && given.initial.empty())
    return draft.refuse("body", "absent", "must be given, or inertia and initial");
  if (!given.body) return check_rigid_body(draft, false);
  draft.refuse_other_numbers();
  check_body(draft);
}

/// Returns the start of a body given in engineers' terms; [I, R] are its principal axes.
template <class Scalar>
SeriesStart<Scalar> start_of_given(const SceneNumbers<Scalar>& g, const BodyDescription& given) {
  using Dense = Matrix<Scalar>;
  const auto [I, R] = given_axes<Scalar>(GivenBody(given));
  const auto q = g.numbers(Eigen::Vector4d(given.attitude.data()));
  const auto omega = g.numbers(Eigen::Vector3d(given.angular_velocity.data()));
  const Vector3<Scalar> m = I.cwiseProduct(R.transpose() * omega);
  using std::sqrt;
  const Dense attitude = rotation_matrix<Scalar>((q / sqrt(Scalar(q.squaredNorm()))).eval()) * R;
  auto start = g.start(attitude, hat(m));
  start.lambda =
      PrincipalMoments3<Scalar>(I, Vector3<Scalar>(I(1) - I(2), I(2) - I(0), I(0) - I(1))).lambda();
  start.reported.axes = R;
  return start;
}

constexpr auto body_start = [](const auto& g) {
  if (const auto& given = g.scene.description().body) return start_of_given(g, *given);
  return g.start(g.block("Q"), g.block("M"));
};

WithinDomain<Phase> read_body(const Scene& scene, Margins&) {
  return phase_of_body(scene, scene.Q(), scene.M());
}
WithinDomain<FormBlocks> write_body(const Phase& x, const ConversionTarget&, Margins&) {
  return FormBlocks{{{"Q", x.Q}, {"M", x.M}}};
}
constexpr Representation body_representation = {true, read_body, write_body};

constexpr TwoForm form_of_body = {
    {"omega",
     {"Q", "M"},
     "<Z_2, xi_1> - <Z_1, xi_2> + <M, [xi_1, xi_2]> of (Q xi_i, Z_i), <A, B> = -1/2 tr(A B)",
     "[RB] (3.13)"},
    {"Q", "M"},
    [](const Scene&) { return space_of(CotangentOfRotations<double>()); }};

TangentSpace body_space(const Scene&) { return {}; }

constexpr Tangents body_tangents = {body_space, tangents_of_bodies},
                   discrete_tangents = {body_space, tangents_of_maps};

bool in_4d(const Scene& scene) { return scene.dimension() == 4; }
bool away_from_separatrix(const Scene& scene) {
  return scene.dimension() == 3 &&
         body_rates.separatrix(scene.inertia(), vee(body_momentum(scene))) >= next_to_separatrix;
}

constexpr std::array for_bodies = {
    Recommendation{.where = "ensembles, N = 3, no member next to the separatrix",
                   .takes = away_from_separatrix,
                   .members_only = true,
                   .method = "preprocessed_variational",
                   .order = 14,
                   .largest_h_omega = 0.3},
    closed_form_of_body,
    Recommendation{.where = "N = 4",
                   .takes = in_4d,
                   .method = "variational",
                   .order = 8,
                   .largest_h_omega = 0.15},
    with_error_control(1e-12, 0.15)};

/// Returns the data that rigid_body and moser_veselov share, the systems of (Q, M). Their check
/// accepts (Q, M), M alone, or a body in three dimensions given by `body`: inertia tensor or
/// moments, attitude quaternion, angular velocity.
SystemEntry rigid_body_family() {
  SystemInfo info = rigid_form_info({"M", "N x N", true, "body momentum, skew"}, false);
  info.blocks[0] = {"Q", "N x N", false,
                    "frame, orthogonal, body to space; absent in a momentum-only scene"};
  info.fields.back().description =
      "body angular velocity: Omega_ij = M_ij / (lambda_i + lambda_j) in principal axes";
  for (const FieldInfo& field : std::to_array<FieldInfo>({
           {"quaternion", "1 x 4", "N = 3, det Q = 1: w, x, y, z, body to space; sign continuous"},
           {"angular_velocity", "1 x 3", "N = 3: the vector of Omega"},
           {"angular_velocity_space", "1 x 3", "N = 3: the vector of Q Omega Q^T, in space axes"},
           {"momentum_space", "1 x 3", "N = 3: the vector of Q M Q^T, in space axes"},
           {"euler_angles_SEQUENCE", "1 x 3",
            "N = 3, det Q = 1: angles in rad in one of SciPy's sequences, euler_angles_ZXZ about "
            "axes of the body, euler_angles_zxz of space; the first and the third jump by 2 pi, "
            "and a client unwraps them along a run; within 1e-7 of gimbal lock the third is 0"},
           {"euler_rates_SEQUENCE", "1 x 3",
            "N = 3, det Q = 1: the time derivatives of these angles; the largest double where "
            "infinite, at gimbal lock"},
       }))
    info.fields.push_back(field);
  return {.info = info,
          .check = check_momentum_or_body,
          .body_of = body_of,
          .make = make_rigid_body,
          .methods = methods_of_rigid_bodies,
          .two_forms = {&form_of_body},
          .representation = &body_representation,
          .motion = &in_both<body_equations, body_start>,
          .rate = Rate::angular_speed,
          .packs = &body_packs,
          .rates = &body_rates};
}

}  // namespace

const char* const representations::body_system = RigidBody<SoN<double>>::name;

bool has_closed_form(const Scene& scene) { return TurnedBody::has(scene.inertia()); }

bool check_square_inertia(SceneDraft& draft, bool has_epsilon, bool has_parameter) {
  const SceneDescription& given = draft.given();
  draft.refuse_if(given.body.has_value(), "body");
  draft.refuse_if(!has_epsilon && given.epsilon.has_value(), "epsilon");
  draft.refuse_if(!has_parameter && given.parameter.has_value(), "parameter");
  draft.refuse_if(!given.inertia_u.empty(), "inertia_u");
  draft.refuse_if(!given.inertia_v.empty(), "inertia_v");
  if (!draft.set_inertia()) return false;
  draft.check_inertia_sums();
  draft.check_block_names();
  return true;
}

void check_rigid_body(SceneDraft& draft, bool frame_required) {
  if (!check_square_inertia(draft, false, false)) return;
  const Eigen::Index N = draft.scene().dimension();
  if (const RowMatrix* M = draft.block("M", N, N)) draft.set_skew("M", *M);
  if (const RowMatrix* Q = draft.block("Q", N, N, frame_required)) draft.set_frame("Q", *Q);
}

SystemEntry rigid_body_entry() {
  SystemEntry entry = rigid_body_family();
  SystemInfo& info = entry.info;
  info.name = "rigid_body";
  info.summary = "free rigid body in N dimensions";
  info.equations = "Q' = Q Omega, M' = [M, Omega], M = Lambda Omega + Omega Lambda";
  info.source = "[RB] (2.2), (2.3)";
  info.file = "engine/body/rigid_body.h";
  entry.recommended = for_bodies;
  entry.in_float = true;
  entry.tangents = &body_tangents;
  return entry;
}

SystemEntry moser_veselov_entry() {
  SystemEntry entry = rigid_body_family();
  SystemInfo& info = entry.info;
  info.name = "moser_veselov";
  info.summary = "discrete rigid body of Moser and Veselov, its own step as the time";
  info.equations = "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k U, M_{k+1} = U^T M_k U";
  info.source = "[RB] (4.5)";
  info.file = "engine/body/moser_veselov.h";
  info.discrete = true;
  info.velocity = {};
  info.invariants.push_back(discrete_hamiltonian_info);
  entry.continuous = "rigid_body";
  entry.tangents = &discrete_tangents;
  entry.methods = keeps_all;
  return entry;
}

}  // namespace stiefel
