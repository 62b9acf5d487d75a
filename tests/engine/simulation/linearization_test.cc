#include "stiefel/linearization.h"

#include <gtest/gtest.h>

#include "engine/dense/decompositions.h"
#include "engine/motion/system_entry.h"
#include "engine/motion/two_form.h"
#include "engine/structure/symplectic_defect.h"
#include "stiefel/catalogue.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_matrices.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

Scene scene_of(const std::string& system, const std::string& method, unsigned seed, int N = 4,
               int order = 0, int substeps = 1) {
  auto description = testing::any_scene(system, method, seed, 0.1, N);
  if (order > 0) description.method->order = order;
  if (substeps > 1) description.method->substeps = substeps;
  auto scene = Scene::resolve(std::move(description));
  if (!scene) throw std::runtime_error(scene.error().front().rule);
  return *std::move(scene);
}

/// Returns the state's blocks, stacked.
Dense state_of(const Simulation& motion, Eigen::Index rows, Eigen::Index cols) {
  Dense x(rows, cols);
  Eigen::Index top = 0;
  for (std::size_t i = 0; i < motion.block_count() && top < rows; ++i) {
    const Dense block = motion.get(motion.fields()[i].name);
    x.middleRows(top, block.rows()) = block;
    top += block.rows();
  }
  return x;
}

/// Returns vector k of V, numbers row by row, as blocks.
Dense blocks_of(const std::unique_ptr<Linearization>& tangent, const Dense& V, Eigen::Index k) {
  return V.col(k).reshaped<Eigen::RowMajor>(tangent->rows(), tangent->cols());
}

std::unique_ptr<Linearization> made(const Scene& scene, const Simulation& start,
                                    LinearizationDescription what = {}) {
  auto tangent = Linearization::make(scene, std::move(what), start);
  if (!tangent) throw std::runtime_error(tangent.error().front().rule);
  return *std::move(tangent);
}

/// Moves the basis of the tangent space, as blocks.
LinearizationDescription basis_as_blocks(const Scene& scene, const Simulation& start) {
  const auto coordinates = made(scene, start);
  return {coordinates->basis(start), true, false, false};
}

/// Returns the state after a step of the scene that starts from these blocks: a view has constants
/// of its first state, which Simulation::image does not have from others.
std::optional<Dense> after_a_step(const Scene& scene, const Dense& blocks) {
  SceneDescription other = scene.description();
  other.initial.clear();
  const auto here = make_simulation(scene);
  for (std::size_t i = 0; i < here->block_count(); ++i)
    other.initial[here->fields()[i].name] = Block(
        RowMatrix(blocks.middleRows(static_cast<Eigen::Index>(i) * blocks.cols(), blocks.cols())));
  const auto moved = Scene::resolve(other, Scene::drift_tolerance);
  if (!moved) return std::nullopt;
  const auto motion = make_simulation(*moved);
  if (!motion->advance(1).reached()) return std::nullopt;
  return state_of(*motion, blocks.rows(), blocks.cols());
}

/// The tangent of one step against central differences of the step itself.
void expect_derivative_of_step(const Scene& scene, const std::string& what) {
  const auto motion = make_simulation(scene);
  auto tangent = made(scene, *motion, basis_as_blocks(scene, *motion));
  const Dense start = tangent->vectors(*motion);
  const Dense x = state_of(*motion, tangent->rows(), tangent->cols());
  const auto before = make_simulation(scene);
  ASSERT_TRUE(tangent->advance(*motion, 1).reached()) << what;
  const Dense end = tangent->vectors(*motion);
  const auto phi = [&](const Dense& y) {
    if (system_entry(scene.system())->view) return after_a_step(scene, y);
    std::optional<Dense> z = y;
    for (int k = 0; k < scene.substeps() && z; ++k) z = before->image(*z);
    return z;
  };
  for (Eigen::Index k = 0; k < start.cols(); ++k) {
    const auto expected = derivative<double>(phi, x, blocks_of(tangent, start, k));
    ASSERT_TRUE(expected) << what;
    EXPECT_LT((blocks_of(tangent, end, k) - *expected).norm(), 2e-11 * expected->norm())
        << what << " vector " << k;
  }
}

TEST(Linearization, IsTheDerivativeOfTheStep) {
  for (const SystemInfo& system : catalogue().systems)
    for (const MethodOnSystem& on : system.methods) {
      const std::string method(on.method);
      if (!on.has_tangent) continue;
      for (const int N : {3, 4}) {
        if (!on.where.empty() && N != 3) continue;  // for N = 3 alone
        const std::string name(system.name);
        expect_derivative_of_step(scene_of(name, method, 3, N),
                                  name + " " + method + " " + std::to_string(N));
      }
    }
}

TEST(Linearization, OfCompositionsAndSubsteps) {
  for (const char* system : {"rigid_body", "stiefel"})
    for (const int order : {4, 6, 8})
      expect_derivative_of_step(scene_of(system, "variational", 5, 5, order),
                                std::string(system) + " of order " + std::to_string(order));
  expect_derivative_of_step(scene_of("rigid_body", "variational", 5, 5, 2, 3), "substeps");
  for (const int order : {6, 10, 16})
    expect_derivative_of_step(scene_of("rigid_body", "preprocessed_variational", 5, 3, order),
                              "preprocessed " + std::to_string(order));
}

/// ω(Φu, Φv) = ω(u, v), relative to the lengths of Φu and Φv.
TEST(Linearization, OfSymplecticMethodsKeepsTheForm) {
  struct Case {
    const char *system, *method;
    int N;
  };
  for (const auto& [system, method, N] :
       {Case{"rigid_body", "variational", 3}, Case{"rigid_body", "variational", 5},
        Case{"stiefel", "variational", 5}}) {
    const Scene scene = scene_of(system, method, 7, N);
    const auto motion = make_simulation(scene);
    auto tangent = made(scene, *motion, basis_as_blocks(scene, *motion));
    const TwoForm& form = *system_entry(scene.system())->two_forms.front();
    const FormSpace space = form.space(scene);
    const Dense start = tangent->vectors(*motion);
    const Dense x = state_of(*motion, tangent->rows(), tangent->cols());
    ASSERT_TRUE(tangent->advance(*motion, 10000).reached());
    const Dense end = tangent->vectors(*motion);
    const Dense y = state_of(*motion, tangent->rows(), tangent->cols());
    const double size = end.norm();
    for (Eigen::Index i = 0; i < start.cols(); ++i)
      for (Eigen::Index j = 0; j < i; ++j)
        EXPECT_NEAR(space.form(y, blocks_of(tangent, end, i), blocks_of(tangent, end, j)),
                    space.form(x, blocks_of(tangent, start, i), blocks_of(tangent, start, j)),
                    1e-12 * size * size)
            << system << " " << method << " " << N;
  }
}

/// Returns the largest change of the two-form by `steps` steps of a body.
double change_of_form(const std::string& method, int order, double h, std::int64_t steps) {
  auto description = testing::any_scene("rigid_body", method, 8, h, 3);
  description.method->order = order;
  const Scene scene = *Scene::resolve(std::move(description));
  const auto motion = make_simulation(scene);
  auto tangent = made(scene, *motion, basis_as_blocks(scene, *motion));
  const FormSpace space = system_entry("rigid_body")->two_forms.front()->space(scene);
  const Dense start = tangent->vectors(*motion), x = state_of(*motion, 6, 3);
  EXPECT_TRUE(tangent->advance(*motion, steps).reached());
  const Dense end = tangent->vectors(*motion), y = state_of(*motion, 6, 3);
  double largest = 0;
  for (Eigen::Index i = 0; i < start.cols(); ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      largest = std::max(
          largest,
          std::abs(space.form(y, blocks_of(tangent, end, i), blocks_of(tangent, end, j)) -
                   space.form(x, blocks_of(tangent, start, i), blocks_of(tangent, start, j))));
  return largest;
}

/// The modified moments are constant along a motion and differ from motion to motion, so the step
/// is symplectic to its order: the defect of a step is proportional to h^(p+1), and that of many
/// steps to their number. Held-fixed moments would leave rounding errors, as `variational` does.
TEST(Linearization, OfPreprocessedKeepsTheFormToItsOrder) {
  EXPECT_LT(change_of_form("variational", 2, 0.2, 1), 1e-14);
  for (const int order : {4, 6}) {
    const double one = change_of_form("preprocessed_variational", order, 0.2, 1),
                 half = change_of_form("preprocessed_variational", order, 0.1, 1);
    EXPECT_NEAR(std::log2(one / half), order + 1, 0.1) << order;
    EXPECT_NEAR(change_of_form("preprocessed_variational", order, 0.2, 1000), 1000 * one,
                0.01 * 1000 * one)
        << order;
  }
}

/// A frame with columns of zeros behind it moves as the frame does, in more than one tile.
TEST(Linearization, OfManyColumnsIsThatOfFew) {
  for (const auto& [n, order, arithmetic] : {std::tuple(1, 2, "compensated"),
                                             {2, 4, "plain"},
                                             {3, 2, "compensated"},
                                             {4, 6, "compensated"},
                                             {5, 2, "plain"},
                                             {6, 2, "compensated"}}) {
    constexpr int few = 9;
    testing::RandomMatrices<double> random(static_cast<unsigned>(n));
    const Dense Q = random.frame(n, few), A = random.matrix(n, few);
    const Eigen::VectorXd lambda = random.lambda(few);
    const Dense R = A * Q.transpose(), V = (A - (R + R.transpose()) * Q / 2) / A.norm();
    const auto scene_with = [&](int columns) {
      const auto wide = [&](const Dense& x) {
        Dense out = Dense::Zero(x.rows(), columns);
        out.leftCols(few) = x;
        return out;
      };
      SceneDescription description;
      description.system = "stiefel";
      description.method = MethodDescription{"variational", order, 2, arithmetic};
      description.inertia.assign(lambda.begin(), lambda.end());
      description.inertia.resize(static_cast<std::size_t>(columns), 1.5);
      description.initial = {{"Q", Block(wide(Q))}, {"S", Block(wide(V * lambda.asDiagonal()))}};
      description.step = 0.2;
      return Scene::resolve(std::move(description)).value();
    };
    const Scene scene = scene_with(few);
    const auto motion = make_simulation(scene);
    const Dense basis = made(scene, *motion)->basis(*motion);
    auto tangent = made(scene, *motion, {basis, true, true, true});
    ASSERT_TRUE(tangent->advance(*motion, 3).reached());
    const Dense expected = tangent->vectors(*motion);
    for (const int columns : {64, 64 + few, 200}) {
      const Scene wide_scene = scene_with(columns);
      const auto wide_motion = make_simulation(wide_scene);
      Dense vectors = Dense::Zero(2 * n * columns, basis.cols());
      for (int row = 0; row < 2 * n; ++row)
        vectors.middleRows(row * columns, few) = basis.middleRows(row * few, few);
      auto wide = made(wide_scene, *wide_motion, {vectors, true, true, true});
      ASSERT_TRUE(wide->advance(*wide_motion, 3).reached());
      const Dense found = wide->vectors(*wide_motion);
      for (Eigen::Index k = 0; k < expected.cols(); ++k) {
        // Then come the derivatives by λ, of which the wide frame has more, and by the step.
        const Eigen::Index other = k < basis.cols() + few ? k : found.cols() - 1;
        double off = 0;
        for (int row = 0; row < 2 * n; ++row)
          off += (found.col(other).segment(row * columns, few) -
                  expected.col(k).segment(row * few, few))
                     .squaredNorm();
        EXPECT_LT(std::sqrt(off), 1e-13 * (1 + expected.col(k).norm()))
            << "V(" << n << ", " << columns << ") vector " << k;
      }
    }
  }
}

/// The states are those of a simulation alone, and the vectors do not depend on how the steps are
/// divided into calls, nor on the vectors beside them.
TEST(Linearization, ChangesNoBit) {
  for (const char* system : {"rigid_body", "stiefel"}) {
    const Scene scene = scene_of(system, "variational", 11, 4);
    const auto alone = make_simulation(scene), motion = make_simulation(scene),
               other = make_simulation(scene);
    ASSERT_TRUE(alone->advance(50).reached());
    const LinearizationDescription all = basis_as_blocks(scene, *motion);
    auto whole = made(scene, *motion, all);
    LinearizationDescription one = all;
    one.vectors = all.vectors->col(all.vectors->cols() - 1);
    auto part = made(scene, *other, one);
    ASSERT_TRUE(whole->advance(*motion, 50).reached());
    for (int k = 0; k < 50; ++k) ASSERT_TRUE(part->advance(*other, 1).reached());
    std::vector<double> a(alone->saved_size()), b(a);
    alone->save(a);
    motion->save(b);
    EXPECT_EQ(a, b);
    EXPECT_EQ(whole->vectors(*motion).rightCols(1), part->vectors(*other));
  }
}

TEST(Linearization, RefusesWhatItCannot) {
  const auto refusal = [](const std::string& system, const std::string& method) {
    const Scene scene = scene_of(system, method, 1);
    const auto refused = Linearization::make(scene, {}, *make_simulation(scene));
    return refused ? Violation{} : refused.error().front();
  };
  for (const char* method : {"adaptive", "munthe_kaas4"}) {
    const Violation by_method = refusal("rigid_body", method);
    EXPECT_EQ(by_method.field, "method");
    EXPECT_EQ(by_method.value, method);
    EXPECT_EQ(by_method.rule,
              "has no tangent for rigid_body at N = 4; exact (N = 3), variational, "
              "preprocessed_variational, rk4 have");
  }
  const Violation by_system = refusal("double_bracket", "rk4");
  EXPECT_EQ(by_system.field, "system");
  EXPECT_EQ(by_system.value, "double_bracket");
  EXPECT_EQ(by_system.rule,
            "has no tangent by any method; rigid_body, right_rigid_body, "
            "right_symmetric_rigid_body, reduced_rigid_body, mclachlan_scovel, stiefel, "
            "moser_veselov, moser_veselov_pair, discrete_stiefel have one");
  const Scene scene = scene_of("rigid_body", "variational", 1);
  const auto motion = make_simulation(scene);
  const auto off = Linearization::make(scene, {Dense::Ones(32, 1), true, false, false}, *motion);
  ASSERT_FALSE(off);
  EXPECT_EQ(off.error().front().field, "vectors[0]");
  EXPECT_FALSE(Linearization::make(scene, {Dense::Ones(5, 1), false, false, false}, *motion));
}

/// A closed form has no steps in between: the derivative over 10⁸ steps is that by the formula.
TEST(Linearization, OfAClosedFormIsDirect) {
  const Scene scene = scene_of("rigid_body", "exact", 2, 3);
  const auto motion = make_simulation(scene), near = make_simulation(scene);
  auto tangent = made(scene, *motion), twice = made(scene, *near);
  ASSERT_TRUE(tangent->advance(*motion, 100'000'000).reached());
  const Dense Phi = tangent->vectors(*motion);
  EXPECT_TRUE(Phi.allFinite());
  // Φ keeps the volume.
  EXPECT_NEAR(determinant(Phi), 1, 1e-4);
  // Two halves multiply to the whole.
  ASSERT_TRUE(twice->advance(*near, 300).reached());
  const Dense first = twice->vectors(*near);
  auto rest = made(scene, *near);
  ASSERT_TRUE(rest->advance(*near, 500).reached());
  const auto end = make_simulation(scene);
  auto direct = made(scene, *end);
  ASSERT_TRUE(direct->advance(*end, 800).reached());
  const Dense expected = direct->vectors(*end);
  EXPECT_LT((rest->vectors(*near) * first - expected).norm(), 1e-12 * expected.norm());
}

}  // namespace
}  // namespace stiefel
