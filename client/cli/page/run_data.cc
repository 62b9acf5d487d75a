#include "client/cli/page/run_data.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "client/cli/report.h"

namespace stiefel::cli {
namespace {

constexpr std::int64_t drifts = 60;  ///< points of a curve of drifts
constexpr double errors = 20;        ///< parts of a curve of errors, between 21 points
/// Instructions that a curve of errors may take; a dearer one has fewer parts, but at least one.
constexpr double dearest = 2e9;

v1::DiagnoseResponse diagnose(const client::Session& session, std::int64_t step,
                              v1::ErrorEstimation estimate) {
  v1::DiagnoseRequest request;
  request.set_to(step);
  request.set_estimate_error(estimate);
  return session.diagnose(request);
}

/// Returns `count` + 1 whole numbers from 0 to `last`, or fewer where that has not as many.
std::set<std::int64_t> spread(std::int64_t last, std::int64_t count) {
  std::set<std::int64_t> numbers;
  for (std::int64_t k = 0; k <= count; ++k)
    numbers.insert(static_cast<std::int64_t>(static_cast<double>(last) * k / count));
  numbers.insert(last);
  return numbers;
}

class Families {
 public:
  void add(const v1::DiagnoseResponse& diagnosis) {
    for (const auto& invariant : diagnosis.invariants()) {
      auto& family = find(invariant.name().substr(0, invariant.name().find('[')),
                          to_string(invariant.conservation()));
      if (family.drift.size() <= times_) family.drift.push_back(0);
      family.drift.back() = std::max(family.drift.back(), invariant.drift());
      if (times_ == 0) ++family.count;
    }
    for (const auto& shortened : diagnosis.shortened())
      find(shortened.name(), "").count = shortened.count();
    if (diagnosis.has_orthogonality()) {
      auto& family = find("orthogonality", "");
      family.drift.push_back(diagnosis.orthogonality());
      family.count = 1;
    }
    ++times_;
  }

  nlohmann::ordered_json json() const {
    auto out = nlohmann::ordered_json::array();
    for (const auto& family : families_)
      out.push_back({{"name", family.name},
                     {"conservation", family.conservation},
                     {"count", family.count},
                     {"drift", family.drift}});
    return out;
  }

 private:
  struct Family {
    std::string name, conservation;
    std::uint64_t count = 0;
    std::vector<double> drift;
  };

  Family& find(const std::string& name, const std::string& conservation) {
    const auto found = std::ranges::find(families_, name, &Family::name);
    if (found != families_.end()) return *found;
    return families_.emplace_back(Family{name, conservation, 0, {}});
  }

  std::vector<Family> families_;
  std::size_t times_ = 0;
};

void add_error(nlohmann::ordered_json& curve, const v1::DiagnoseResponse& diagnosis) {
  const auto& error = diagnosis.estimated_error();
  if (error.reference().empty()) return;
  const double bound = 2 * error.reference_error();
  curve["time"].push_back(diagnosis.time());
  curve["attitude"].push_back(error.has_attitude() ? error.attitude() : bound);
  curve["momentum"].push_back(error.has_momentum() ? error.momentum() : bound);
}

}  // namespace

RunData diagnose_run(const client::Session& session, std::int64_t to,
                     v1::ErrorEstimation estimate) {
  RunData run;
  run.last = diagnose(session, to, estimate);
  const auto& estimated = run.last.estimated_error();
  const auto steps = spread(run.last.step(), drifts);
  // The estimate at step k takes k / last of the work of that at the last: n parts take (n + 1) / 2
  // of it.
  std::set<std::int64_t> points;
  if (!estimated.reference().empty())
    points = spread(
        static_cast<std::int64_t>(steps.size()) - 1,
        static_cast<std::int64_t>(std::clamp(
            2 * dearest / std::max(1.0, static_cast<double>(estimated.work())) - 1, 1.0, errors)));
  const auto none = nlohmann::ordered_json::array();
  run.drift = {{"time", none}};
  run.error = {{"time", none}, {"attitude", none}, {"momentum", none}};
  Families families;
  std::int64_t index = 0;
  for (const std::int64_t step : steps) {
    const bool estimate_here = points.contains(index++);
    const auto diagnosis =
        step == run.last.step()
            ? run.last
            : diagnose(session, step, estimate_here ? estimate : v1::ERROR_ESTIMATION_UNSPECIFIED);
    families.add(diagnosis);
    run.drift["time"].push_back(diagnosis.time());
    run.speed = std::max(run.speed, diagnosis.domain().h_omega());
    add_error(run.error, diagnosis);
  }
  run.drift["families"] = families.json();
  const auto& scene = session.scene();
  const double substeps = scene.method().has_substeps() ? scene.method().substeps() : 1;
  run.speed *= substeps / std::abs(scene.step());
  return run;
}

}  // namespace stiefel::cli
