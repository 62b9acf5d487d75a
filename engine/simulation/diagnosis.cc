#include "engine/simulation/diagnosis.h"

#include <algorithm>
#include <cmath>

#include "engine/invariants/rigid_body.h"
#include "engine/linalg/orthogonal.h"

namespace stiefel {
namespace {

constexpr int largest_manakov_unasked = 16, largest_domain_search = 32;
constexpr double domain_search_limit = 8;  // in units of |h|

/// What is asked for: families, or single invariants "family[...]".
class Selection {
 public:
  Selection(std::span<const std::string> only) : only_(only) {}
  bool all() const { return only_.empty(); }
  bool wants(std::string_view family) const {
    return all() || std::ranges::any_of(only_, [&](std::string_view s) {
             return s.substr(0, s.find('[')) == family;
           });
  }
  bool wants(std::string_view family, std::string_view name) const {
    return all() ||
           std::ranges::any_of(only_, [&](std::string_view s) { return s == family || s == name; });
  }

 private:
  std::span<const std::string> only_;
};

std::string indexed(std::string_view family, Eigen::Index i) {
  return std::string(family) + "[" + std::to_string(i) + "]";
}
std::string indexed(std::string_view family, Eigen::Index i, Eigen::Index j) {
  return std::string(family) + "[" + std::to_string(i) + "," + std::to_string(j) + "]";
}

Kept kept(const Scene& scene, std::string_view invariant) {
  for (const auto& method : catalogue().system(scene.system())->methods)
    if (method.method == scene.method())
      for (const auto& p : method.preserves)
        if (p.invariant == invariant) return p.kept;
  return Kept::drifts;
}

using Wide = long double;
struct Point {
  Eigen::MatrixXd Q, M;
  Matrix<Wide> wide_M() const { return M.cast<Wide>(); }
};

class Collector {
 public:
  Collector(const Scene& scene, Selection wanted, std::vector<InvariantDrift>& out)
      : scene_(scene), lambda_(scene.inertia().cast<Wide>()), wanted_(wanted), out_(out) {}

  void add(std::string_view family, std::string name, Wide initial, Wide value, Wide scale) {
    if (wanted_.wants(family, name))
      out_.push_back({std::move(name), static_cast<double>(initial), static_cast<double>(value),
                      static_cast<double>(scale), kept(scene_, family)});
  }

  void energies(const Point& start, const Point& now) {
    const Wide E = energy<Wide>(lambda_, start.wide_M());
    add("energy", "energy", E, energy<Wide>(lambda_, now.wide_M()), E);
  }

  void spatial_momenta(const Point& start, const Point& now, Wide norm) {
    const Eigen::MatrixXd before = spatial_momentum<double>(start.Q, start.M);
    const Eigen::MatrixXd after = spatial_momentum<double>(now.Q, now.M);
    for (Eigen::Index i = 0; i < before.rows(); ++i)
      for (Eigen::Index j = i + 1; j < before.cols(); ++j)
        add("spatial_momentum", indexed("spatial_momentum", i + 1, j + 1), before(i, j),
            after(i, j), norm);
  }

  void all_casimirs(const Eigen::VectorXd& before, const Point& now) {
    const Eigen::VectorXd after = casimirs<double>(now.M);
    for (Eigen::Index k = 0; k < before.size(); ++k)
      add("casimirs", indexed("casimirs", k + 1), before(k), after(k), before(0));
  }

  /// Coefficients of μʲ in tr(M + μΛ²)ᵏ, scaled by C(k,j) ‖M‖ᵏ⁻ʲ ‖Λ²‖ʲ. Those with k − j odd are 0,
  /// the one with j = k is a constant of the scene.
  void manakov_coefficients(const Point& start, const Point& now, Wide norm) {
    const int N = scene_.dimension();
    const auto before = manakov<Wide>(lambda_, start.wide_M(), N);
    const auto after = manakov<Wide>(lambda_, now.wide_M(), N);
    const Wide lambda2 = lambda_.cwiseAbs2().maxCoeff();
    for (int k = 2; k <= N; ++k)
      for (int j = k % 2; j <= k - 2; j += 2) {
        const Wide binomial = std::exp(std::lgamma(k + 1.0L) - std::lgamma(j + 1.0L) -
                                       std::lgamma(static_cast<Wide>(k - j) + 1));
        add("manakov", indexed("manakov", k, j), before[k][j], after[k][j],
            binomial * std::pow(norm, static_cast<Wide>(k - j)) *
                std::pow(lambda2, static_cast<Wide>(j)));
      }
  }

 private:
  const Scene& scene_;
  Vector<Wide> lambda_;
  Selection wanted_;
  std::vector<InvariantDrift>& out_;
};

/// ‖Ω‖, the operator norm.
double angular_velocity_norm(const Scene& scene, const Eigen::MatrixXd& M) {
  Eigen::MatrixXd Omega = M;
  for (Eigen::Index j = 0; j < M.cols(); ++j)
    for (Eigen::Index i = 0; i < M.rows(); ++i)
      if (i != j) Omega(i, j) /= scene.inertia()(i) + scene.inertia()(j);
  return casimirs<double>(Omega)(0);
}

}  // namespace

double InvariantDrift::drift() const {
  const double change = std::abs(value - initial);
  return change == 0 ? 0 : change / scale;
}

bool is_invariant(const Scene& scene, std::string_view name_or_family) {
  const std::string_view family = name_or_family.substr(0, name_or_family.find('['));
  const auto& known = catalogue().system(scene.system())->invariants;
  return std::ranges::any_of(known, [&](const auto& i) { return i.name == family; });
}

Diagnosis diagnose(const Scene& scene, const Simulation& now, std::span<const std::string> only) {
  const Selection wanted(only);
  const auto initial = make_simulation(scene);
  const Point start{initial->Q(), initial->M()}, end{now.Q(), now.M()};
  const Eigen::VectorXd start_casimirs = casimirs<double>(start.M);
  const double norm = start_casimirs(0);

  Diagnosis diagnosis;
  Collector collector(scene, wanted, diagnosis.invariants);
  if (wanted.wants("energy")) collector.energies(start, end);
  if (wanted.wants("spatial_momentum") && scene.has_frame())
    collector.spatial_momenta(start, end, norm);
  if (wanted.wants("casimirs")) collector.all_casimirs(start_casimirs, end);
  if (wanted.all() ? scene.dimension() <= largest_manakov_unasked : wanted.wants("manakov"))
    collector.manakov_coefficients(start, end, norm);
  if (scene.has_frame()) diagnosis.orthogonality = orthogonality_defect(end.Q);

  const double h = std::abs(scene.step()) / scene.substeps();
  diagnosis.h_omega = h * angular_velocity_norm(scene, end.M);
  if (scene.dimension() <= largest_domain_search)
    diagnosis.largest_step = now.largest_step(domain_search_limit * h);
  return diagnosis;
}

}  // namespace stiefel
