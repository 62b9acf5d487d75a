#include "tests/support/surveys/recommendation_survey.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>

#include "engine/accuracy/candidates.h"
#include "engine/accuracy/measurement.h"
#include "engine/dense/decompositions.h"
#include "engine/motion/system_entry.h"
#include "stiefel/price.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_matrices.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel::testing {
namespace {

constexpr double rotations = 100, wanted = 1e-8;

class SceneMaker {
 public:
  SceneMaker(const std::string& system, unsigned seed, int largest_N)
      : seed_(seed), generator_(seed), largest_N_(largest_N) {
    d_.system = system;
    spread_ = std::pow(10, uniform(0.5, 2));
    values_ = uniform(0, 1) < 0.9 ? 0 : uniform(0, 1) < 0.7 ? 2 : 1;
  }

  SceneDescription made() {
    const std::string system = d_.system;  // an example replaces d_
    if (const auto example = system_entry(system)->example) {
      d_ = example(seed_);
      d_.system = system;
    } else if (system == "double_bracket")
      double_bracket();
    else if (system.starts_with("parametric"))
      parametric();
    else if (system.starts_with("stiefel") || system == "ellipsoid")
      frames();
    else
      body();
    d_.step = 1;
    SceneDescription probe = d_;
    probe.method = MethodDescription{"rk4", {}, {}, ""};
    const double rate = make_simulation(Scene::resolve(probe).value())->rate();
    d_.step = (uniform(0, 1) < 0.5 ? -1 : 1) * uniform(0.05, 0.3) / rate;
    return d_;
  }

 private:
  double uniform(double low, double high) {
    return low + (high - low) * std::generate_canonical<double, 53>(generator_);
  }
  int whole(int low, int high) { return low + static_cast<int>(uniform(0, high - low + 1)); }

  /// Returns Λ with all its values, or with only `values_` different ones.
  Eigen::VectorXd lambda(const Eigen::VectorXd& all) const {
    Eigen::VectorXd few = all;
    for (Eigen::Index i = 0; values_ > 0 && i < all.size(); ++i)
      few(i) = all(i % 3 == 0 && values_ == 2 ? 0 : all.size() - 1);
    return few;
  }

  void body() {
    const int N = uniform(0, 1) < 0.4 ? whole(3, 4) : whole(2, largest_N_);
    const RandomBody body(N, seed_, spread_);
    const double mass = std::pow(10, uniform(-0.3, 0.3)), rate = std::pow(10, uniform(-0.3, 0.3));
    const Eigen::VectorXd l = lambda(body.lambda);
    d_.inertia = numbers(mass * l);
    const bool bare = d_.system == "rigid_body" && uniform(0, 1) < 0.3;
    if (!bare) d_.initial["Q"] = body.Q;
    if (d_.system.find("symmetric") != std::string::npos ||
        (d_.system == "reduced_rigid_body" && uniform(0, 1) < 0.5)) {
      if (uniform(0, 1) < 0.5) {  // two frames
        d_.initial["P"] = RandomBody(N, seed_ + 1000).Q;
        return;
      }
    }
    d_.initial["M"] = mass * rate * body.M;
  }

  /// Sets Q and P with Q⁻¹P = W + (I + W²)^{1/2}, W = (M + μΛ²)/2. Q grows like e^{μλt}, at most by
  /// a factor e.
  void parametric() {
    const int N = whole(2, std::min(largest_N_, 6));
    const RandomBody body(N, seed_, std::min(spread_, 5.0));
    const Eigen::MatrixXd M = body.M / body.M.norm();
    const double longest = rotations * 2 * std::numbers::pi * body.M.norm();
    const double mu = uniform(-1, 1) / (longest * body.lambda.maxCoeff());
    Eigen::MatrixXd W = M;
    W.diagonal() += mu * body.lambda.cwiseAbs2();
    W /= 2;
    const Eigen::MatrixXd root = principal_root(Eigen::MatrixXd::Identity(N, N) + W * W);
    d_.inertia = numbers(body.lambda);
    d_.parameter = mu;
    d_.initial["Q"] = body.Q;
    d_.initial["P"] = Eigen::MatrixXd(body.Q * (W + root));
  }

  void frames() {
    const bool vector = d_.system == "ellipsoid";
    const int N = whole(2, largest_N_), n = vector ? 1 : whole(1, std::min(N - 1, 4));
    RandomFrame<double> frame(n, N, seed_, values_ == 1 ? 1 : spread_);
    const double mass = std::pow(10, uniform(-0.3, 0.3)), rate = std::pow(10, uniform(-0.3, 0.3));
    const Eigen::MatrixXd Qdot = rate * frame.S * frame.lambda.cwiseInverse().asDiagonal();
    const Eigen::MatrixXd S = mass * rate * frame.S, &Q = frame.Q;
    d_.inertia = numbers(mass * frame.lambda);
    d_.initial[vector ? "q" : "Q"] = Q;
    if (vector && uniform(0, 1) < 0.5)
      d_.initial["p"] = S;
    else if (vector)
      d_.initial["qdot"] = Qdot;
    else if (d_.system == "stiefel")
      d_.initial["S"] = S;
    else if (d_.system == "stiefel_costate")
      d_.initial["P"] = Eigen::MatrixXd(S + 0.3 * mass * rate * Q);
    else
      d_.initial["M"] = Eigen::MatrixXd(Q.transpose() * S - S.transpose() * Q);
  }

  void double_bracket() {
    RandomMatrices<double> random(seed_);
    const int p = whole(1, std::min(4, largest_N_)), q = whole(1, std::min(5, largest_N_));
    d_.inertia_u = numbers(random.lambda(p, std::min(spread_, 10.0)));
    d_.inertia_v = numbers(random.lambda(q, std::min(spread_, 10.0)));
    for (const char* name : {"Q", "P"})
      d_.initial[name] = Block(RowMatrix(random.matrix(p, q)), RowMatrix(random.matrix(p, q)));
  }

  SceneDescription d_;
  unsigned seed_;
  std::mt19937_64 generator_;
  int largest_N_, values_;
  double spread_;
};

/// Returns the larger of max |A − Â| / max |Â| for attitude and momentum.
double relative_error(const MotionState& state, const MotionState& exact) {
  const auto of = [](const Matrix<long double>& a, const Matrix<long double>& b) -> double {
    if (a.size() == 0 || b.size() == 0) return 0;
    return static_cast<double>((a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff());
  };
  const double error =
      std::max(of(state.attitude, exact.attitude), of(state.momentum, exact.momentum));
  return std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
}

/// Error and work of a run.
struct Judged {
  double error = 0, work = 0;
};
/// Runs a scene over all samples. Ends the run, with an infinite error, when the error exceeds
/// `limit` or the work exceeds `bound`.
Judged judge(const Scene& scene, const Samples& samples, double limit, double bound) {
  const double weight = step_weight(scene);
  const auto now = make_simulation(scene);
  Judged out;
  for (std::size_t i = 0; i < samples.steps.size(); ++i) {
    // A closed form computes each state separately, so that the work counts as in the trade-off.
    const std::int64_t most = now->direct() ? 1 : samples.steps[i];
    while (now->step() < samples.steps[i])
      if (!now->advance(std::min(most, samples.steps[i] - now->step())).reached())
        return {INFINITY, out.work};
    const double error = relative_error(read_motion(scene, *now), samples.states[i].front());
    out.error = std::max(out.error, error);
    out.work = weight * static_cast<double>(now->map_steps());
    const double part = static_cast<double>(samples.last()) / static_cast<double>(now->step());
    const double whole_work = (i > 3 ? part / 1.2 : 1) * out.work;
    if (out.error > limit || whole_work > bound) return {INFINITY, out.work};
  }
  return out;
}

bool on_frames(const std::string& system) {
  return system.starts_with("stiefel") || system == "ellipsoid";
}

/// Returns the factor by which a change of the initial momentum by 1e-10 grows: up to the last
/// sample, or the largest up to any sample.
double condition_of(const Scene& scene, const Samples& samples, bool largest_of_all) {
  constexpr double tiny = 1e-10;
  // Scene::resolve then projects the changed state onto the manifold.
  SceneDescription moved = scene.description();
  for (auto& [name, block] : moved.initial) {
    if (name == "Q" || name == "q") continue;
    std::mt19937_64 generator(7);
    std::normal_distribution<double> normal;
    RowMatrix change(block.values.rows(), block.values.cols());
    for (double& x : change.reshaped()) x = normal(generator);
    if (!on_frames(scene.system())) {
      if (name == "M") change = (change - change.transpose()).eval();
      block.values += tiny * block.values.cwiseAbs().maxCoeff() * change;
      continue;
    }
    const RowMatrix& frame =
        moved.initial.contains("q") ? moved.initial.at("q").values : moved.initial.at("Q").values;
    if (name == "M") {
      const RowMatrix X = change.topRows(frame.rows());
      change = frame.transpose() * X - X.transpose() * frame;
    } else {
      const RowMatrix cross = change * frame.transpose();
      change -= (cross + cross.transpose()) / 2 * frame;
    }
    change *= block.values.cwiseAbs().maxCoeff() / change.cwiseAbs().maxCoeff();
    block.values += tiny * change;
  }
  const auto other = Scene::resolve(moved);
  if (!other) return 1;
  const double time = std::abs(scene.time(samples.last()));
  const auto reference = make_reference(*other, {time, 1e12, false});
  double largest = tiny;
  for (std::size_t i = largest_of_all ? 0 : samples.steps.size() - 1; i < samples.steps.size(); ++i)
    if (const auto now = reference->at(scene.time(samples.steps[i]), {}))
      largest = std::max(largest, relative_error(now->state, samples.states[i].front()));
  return largest / tiny;
}

}  // namespace

SceneDescription scene_without_method(const std::string& system, unsigned seed, int largest_N) {
  return SceneMaker(system, seed, largest_N).made();
}

namespace {

struct Surveyed {
  Scene scene;
  std::int64_t steps;
  Samples samples;
  Judged own;
  RecommendationOutcome outcome;
};

/// Measures the error of the recommended method and the condition on V(n, N) at the end; of a hard
/// scene both at so many times that no passage next to an unstable motion is missed.
Surveyed survey(const SceneDescription& given, bool hard) {
  const Scene scene = resolve_recommending(given).value();
  const double rate = make_simulation(scene)->rate();
  const auto steps = steps_to(rotations * 2 * std::numbers::pi / rate, scene.step());
  MeasuredMotions motion({scene});
  motion.solve_references(steps, hard ? Density::dense : Density::coarse,
                          {std::abs(scene.time(steps)), 1e12, false}, {});
  Surveyed found{scene, steps, motion.samples(), {}, {}};
  RecommendationOutcome& out = found.outcome;
  std::ostringstream what;
  what << scene.system() << " n=" << scene.block(scene.system() == "ellipsoid" ? "q" : "Q").rows()
       << " N=" << scene.dimension() << " h|Omega|=" << rate * scene.step() << " Lambda 1:"
       << (scene.dimension() > 0 ? scene.inertia().maxCoeff() / scene.inertia().minCoeff() : 0);
  out.scene = what.str();
  out.method = to_text(*scene.description().method);
  if (found.samples.steps.empty() || found.samples.last() < steps) {
    out.error = INFINITY;
    out.scene += " (the reference ended)";
    return found;
  }
  out.reference_error = found.samples.errors.back();
  if (hard || on_frames(given.system)) out.condition = condition_of(scene, found.samples, hard);
  found.own = judge(scene, found.samples, INFINITY, INFINITY);
  out.error = found.own.error;
  return found;
}

}  // namespace

SceneDescription hard_scene(const std::string& system, Hard kind, unsigned seed, int largest_N) {
  std::mt19937_64 generator(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * std::generate_canonical<double, 53>(generator);
  };
  const int N = 3 + static_cast<int>(seed) % (largest_N - 2);
  const RandomBody body(N, seed, 4);
  Eigen::VectorXd lambda(N);
  Eigen::MatrixXd M = body.M;
  for (double& l : lambda)
    l = kind == Hard::nearly_equal ? 1 + 1e-6 * uniform(-1, 1)
        : kind == Hard::wide       ? std::pow(10, uniform(-2, 2))
                                   : uniform(1, 4);
  if (kind == Hard::next_to_equilibrium) {
    std::ranges::sort(lambda);
    M *= 1e-6;
    M(0, 2) += lambda(0) + lambda(2);
    M(2, 0) -= lambda(0) + lambda(2);
  }
  SceneDescription d;
  d.system = system;
  d.inertia = numbers(lambda);
  d.initial["Q"] = body.Q;
  d.initial["M"] = M;
  d.step = 1;
  SceneDescription probe = d;
  probe.method = MethodDescription{"rk4", {}, {}, ""};
  d.step = uniform(0.05, 0.3) / make_simulation(Scene::resolve(probe).value())->rate();
  return d;
}

RecommendationOutcome survey_hard_scene(const SceneDescription& description) {
  return survey(description, true).outcome;
}

RecommendationOutcome survey_recommendation(const SceneDescription& description,
                                            const std::optional<MethodDescription>& method) {
  SceneDescription given = description;
  if (method) given.method = method;
  auto [scene, steps, samples, own, out] = survey(given, false);
  if (std::isinf(out.error)) return out;
  const double limit = wanted * out.condition;
  if (limit >= saturated_error) return out;
  double best = own.work;
  SceneDescription open = description;
  open.method.reset();
  const Scene start = motions_of(open).value().front();
  auto all = candidates(start).value();
  std::ranges::stable_sort(all, {}, &Candidate::weight);
  for (const Candidate& candidate : all)
    for (int knob = 0; knob < (candidate.order == 0 ? 1 : candidate.own_steps ? 13 : 17); ++knob) {
      const auto with = *candidate.refined(knob);
      const double least = candidate.weight * with.substeps.value_or(1);
      if (least * static_cast<double>(steps) >= best) break;
      const Judged judged = judge(start.with(with).value(), samples, limit, best);
      if (!(judged.error <= limit)) continue;
      if (judged.work < best) {
        best = judged.work;
        out.cheapest = to_text(with);
      }
      break;
    }
  out.cost = own.work / best;
  return out;
}

}  // namespace stiefel::testing
