#include "stiefel/lyapunov.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <numbers>

#include "stiefel/catalogue.h"
#include "stiefel/linearization.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_matrices.h"
#include "tests/support/scenes/spectra.h"

namespace stiefel {
namespace {

using namespace testing;

using Dense = Eigen::MatrixXd;

/// λ and −λ, a sum of zero, and zeros by the number of integrals and symmetries, within the errors.
void expect_hamiltonian(const std::unique_ptr<LyapunovExponents>& spectrum, Eigen::Index zeros,
                        unsigned seed) {
  const Eigen::VectorXd lambda = spectrum->exponents(), error = spectrum->errors();
  const Eigen::Index d = lambda.size();
  for (Eigen::Index i = 0; i < d / 2; ++i)
    EXPECT_LE(std::abs(lambda(i) + lambda(d - 1 - i)), error(i) + error(d - 1 - i))
        << said(spectrum, seed);
  EXPECT_LE(std::abs(lambda.sum()), error.maxCoeff()) << said(spectrum, seed);
  Eigen::Index found = 0;
  for (Eigen::Index i = 0; i < d; ++i) found += std::abs(lambda(i)) <= error(i);
  EXPECT_GE(found, zeros) << said(spectrum, seed);
}

const std::vector<double> distinct_4 = {1, 2, 5, 10}, distinct_3 = {1, 2, 4};

TEST(LyapunovTest, BodiesAreRegular) {
  for (const unsigned seed : {1u, 2u, 3u})
    for (const auto& inertia : {std::vector<double>{2.5, 1.5, 0.5}, {4, 3, 2, 1.5}}) {
      const Scene scene = resolved(body(inertia, seed, 0.2));
      const auto spectrum = spectrum_of(scene, {.to = 50000});
      EXPECT_EQ(spectrum->kind(), MotionKind::regular) << said(spectrum, seed);
      expect_hamiltonian(spectrum, spectrum->exponents().size(), seed);
    }
}

TEST(LyapunovTest, GeodesicsOfEllipsoidsAndRoundMetricsAreRegular) {
  for (const unsigned seed : {1u, 2u, 3u})
    for (const auto& description :
         {geodesic(1, distinct_4, seed, 0.1), geodesic(2, {1, 1, 1, 1}, seed, 0.1)}) {
      const auto spectrum = spectrum_of(resolved(description), {.to = 30000});
      EXPECT_EQ(spectrum->kind(), MotionKind::regular) << said(spectrum, seed);
      expect_hamiltonian(spectrum, spectrum->exponents().size(), seed);
    }
}

/// Frames of two rows with distinct Λ: d = 14 of V(2, 5), of which energy and flow, m = QSᵀ − SQᵀ
/// and its rotations give four zeros.
TEST(LyapunovTest, FramesOfTwoRowsAreChaotic) {
  const auto spectrum =
      spectrum_of(resolved(geodesic(2, {1, 2, 5, 10, 20}, 1, 0.1)), {.to = 30000});
  EXPECT_EQ(spectrum->kind(), MotionKind::chaotic) << said(spectrum, 1);
  EXPECT_GT(spectrum->exponents()(0), 3 * spectrum->errors()(0)) << said(spectrum, 1);
  expect_hamiltonian(spectrum, 4, 1);
}

/// The logarithm of how far two simulated motions part from 1e-8, brought back whenever they are
/// 1e-6 apart.
double separation(const Scene& scene, double time) {
  constexpr double near = 1e-8;
  auto description = scene.description();
  const auto motion = make_simulation(scene);
  const auto state = [](const Simulation& at) {
    Dense x(4, at.get("Q").cols());
    x << at.get("Q"), at.get("S");
    return x;
  };
  Dense aside = RandomMatrices<double>(77).matrix(4, scene.dimension());
  double growth = 0;
  const auto steps = static_cast<std::int64_t>(time / scene.step());
  for (std::int64_t done = 0; done < steps; done += 20) {
    const Dense x = state(*motion);
    const Dense y = x + near * aside / aside.norm();
    description.initial["Q"] = Block(Dense(y.topRows(2)));
    description.initial["S"] = Block(Dense(y.bottomRows(2)));
    const auto other = make_simulation(resolved(description));
    const double before = (state(*other) - x).norm();
    if (!motion->advance(20).reached() || !other->advance(20).reached()) return NAN;
    aside = state(*other) - state(*motion);
    growth += std::log(aside.norm() / before);
  }
  return growth / time;
}

TEST(LyapunovTest, TheLargestExponentIsTheRateAtWhichTwoMotionsPart) {
  const Scene scene = resolved(geodesic(2, distinct_4, 1, 0.1));
  const auto spectrum = spectrum_of(scene, {.to = 30000, .count = 1});
  EXPECT_EQ(spectrum->kind(), MotionKind::chaotic) << said(spectrum);
  EXPECT_NEAR(separation(scene, 3000), spectrum->exponents()(0), spectrum->errors()(0));
}

TEST(LyapunovTest, GaliIsTheVolumeOfVectorsThatMoveAlone) {
  const Scene scene = resolved(geodesic(2, distinct_3, 4, 0.05));
  const auto fine = spectrum_of(scene, {.to = 2000, .count = 4, .interval = 1, .seed = 9});
  const auto coarse = spectrum_of(scene, {.to = 2000, .count = 4, .interval = 100, .seed = 9});
  EXPECT_LT((fine->log_gali() - coarse->log_gali()).norm(), 1e-6);
  EXPECT_LT((fine->exponents() - coarse->exponents()).norm(), 1e-9);
  EXPECT_LT(coarse->log_gali()(2), coarse->log_gali()(0));
}

/// A rotation about the middle axis grows by exp(t √((I1−I2)(I2−I3)/(I1 I3)) ω), as it does alone.
TEST(LyapunovTest, AnUnstableRotationHasItsExponentAndIsNotChaotic) {
  SceneDescription description;
  description.system = "rigid_body";
  description.method = MethodDescription{"variational", 4, {}, ""};
  description.body = BodyDescription{{}, {1, 2, 3}, {1, 0, 0, 0}, {0, 1, 0}};
  description.step = 0.1;
  const auto spectrum = spectrum_of(resolved(description), {.to = 20000});
  const double expected = std::sqrt(1.0 * 1.0 / (1 * 3));
  EXPECT_NEAR(spectrum->exponents()(0), expected, spectrum->errors()(0));
  EXPECT_NEAR(spectrum->exponents()(5), -expected, spectrum->errors()(5));
  EXPECT_LT(spectrum->errors()(0), 0.02);
  EXPECT_EQ(spectrum->kind(), MotionKind::undecided) << said(spectrum);
}

TEST(LyapunovTest, TheUnitsDoNotMatter) {
  auto description = geodesic(2, distinct_4, 1, 0.0625);
  const auto one = spectrum_of(resolved(description), {.to = 4000});
  // 2^40 times as fast in units of 2^20 of mass.
  description.step = 0.0625 * 0x1p-40;
  for (double& lambda : description.inertia) lambda *= 0x1p20;
  description.initial["S"].values *= 0x1p60;
  const auto other = spectrum_of(resolved(description), {.to = 4000});
  EXPECT_EQ(one->exponents(), other->exponents() * 0x1p-40);
  EXPECT_EQ(one->log_gali(), other->log_gali());
  EXPECT_EQ(one->kind(), other->kind());
}

TEST(LyapunovTest, AResumedRunHasTheSameBits) {
  const Scene scene = resolved(geodesic(2, distinct_4, 1, 0.1));
  const LyapunovDescription what{.from = 10, .to = 8010};
  const auto begin_at = [&](std::int64_t step) {
    auto motion = make_simulation(scene);
    EXPECT_TRUE(motion->advance(step).reached());
    return motion;
  };
  auto motion = begin_at(10);
  auto whole = begun(scene, what, *motion);
  while (!whole->done()) ASSERT_TRUE(whole->advance(*motion, 1000000).reached());
  std::string saved;
  for (const std::int64_t to : {810, 2010, 4444, 8010}) {
    LyapunovDescription part = what;
    part.to = to;
    motion = begin_at(saved.empty() ? 10 : LyapunovExponents::saved_step(saved));
    auto run = saved.empty() ? LyapunovExponents::make(scene, part, *motion)
                             : LyapunovExponents::resume(scene, part, saved, *motion);
    ASSERT_TRUE(run) << run.error().front().rule;
    while (!(*run)->done()) ASSERT_TRUE((*run)->advance(*motion, 7).reached());
    saved = (*run)->save();
    if (to != what.to) continue;
    EXPECT_EQ((*run)->exponents(), whole->exponents());
    EXPECT_EQ((*run)->errors(), whole->errors());
    EXPECT_EQ((*run)->log_gali(), whole->log_gali());
    EXPECT_EQ((*run)->reason(), whole->reason());
    EXPECT_EQ(saved, whole->save());
  }
  LyapunovDescription other = what;
  other.seed = 1;
  motion = begin_at(LyapunovExponents::saved_step(saved));
  EXPECT_FALSE(LyapunovExponents::resume(scene, other, saved, *motion));
  EXPECT_FALSE(LyapunovExponents::resume(scene, what, saved.substr(0, saved.size() - 1), *motion));
}

/// Whatever the axes in which a body is given, and by every method that moves it.
TEST(LyapunovTest, ATurnedBodyHasTheExponentsOfItsMoments) {
  Eigen::Matrix3d I;
  I << 2, 0.3, -0.2, 0.3, 2.5, 0.1, -0.2, 0.1, 3;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(I);
  const Eigen::Vector3d omega(0.2, 0.5, 0.3), moments = axes.eigenvalues(),
                                              along = axes.eigenvectors().transpose() * omega;
  for (const char* method : {"exact", "variational", "rk4"}) {
    SceneDescription turned, same;
    turned.body.emplace();
    turned.body->inertia_tensor = {2, 2.5, 3, 0.3, -0.2, 0.1};
    turned.body->angular_velocity = {omega(0), omega(1), omega(2)};
    same.body.emplace();
    same.body->moments = {moments(0), moments(1), moments(2)};
    same.body->angular_velocity = {along(0), along(1), along(2)};
    std::vector<std::unique_ptr<LyapunovExponents>> spectra;
    for (SceneDescription* scene : {&turned, &same}) {
      scene->system = "rigid_body";
      scene->method = MethodDescription{method, {}, {}, ""};
      scene->step = 0.1;
      spectra.push_back(spectrum_of(resolved(*scene), {.to = 20000}));
    }
    EXPECT_EQ(spectra[0]->kind(), MotionKind::regular) << method << " " << said(spectra[0]);
    EXPECT_EQ(spectra[0]->kind(), spectra[1]->kind()) << method;
    const Eigen::VectorXd off = (spectra[0]->exponents() - spectra[1]->exponents()).cwiseAbs();
    for (Eigen::Index k = 0; k < 6; ++k)
      EXPECT_LE(off(k), spectra[0]->errors()(k) + spectra[1]->errors()(k)) << method << " " << k;
    EXPECT_LT(std::abs(spectra[0]->exponents().sum()), 1e-6) << method;
  }
}

}  // namespace
}  // namespace stiefel
