#include "tests/extremes/extremes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "engine/numbers/to_text.h"
#include "stiefel/catalogue.h"

namespace stiefel::extremes {
namespace {

std::ofstream records;  // closed when nothing is written
bool whole = false;

/// Writes a row of a table, its columns between tabs.
void write(const Record& r) {
  records << r.extreme << ", " << r.row << '\t' << r.system << ' ' << r.method << ' ' << r.order
          << ' ' << r.arithmetic << '\t' << r.outcome << '\t' << r.measure << '\t'
          << to_text(r.value, 3) << '\t' << to_text(r.bound, 3) << ", " << r.why << '\t'
          << r.limit.value_or("") << '\t' << to_text(r.seconds, 3) << '\n';
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

bool long_form() { return whole; }

void report(const Record& r) {
  if (records.is_open()) write(r);
  std::ostringstream what;
  what << r.extreme << ", " << r.row << ": " << r.measure << " by " << r.system << " " << r.method
       << " " << r.order << " " << r.arithmetic << ", " << r.outcome << ", is " << r.value << " ("
       << r.why << ")";
  if (r.limit)  // a bound of 1 or more cannot disprove a known limit
    EXPECT_FALSE(r.value <= r.bound && r.bound < 1)
        << what.str() << ": no limit any more: " << *r.limit;
  else
    EXPECT_LE(r.value, r.bound) << what.str();
}

double rounding_bound(const Scene& scene, std::int64_t steps, double condition) {
  const double n = static_cast<double>(steps);
  const bool plain = scene.method() != "" && scene.arithmetic() == Arithmetic::plain;
  return 100 * condition * unit * (plain ? n : std::sqrt(n));
}

std::string rounding_reason(const Scene& scene, double condition) {
  const bool plain = scene.method() != "" && scene.arithmetic() == Arithmetic::plain;
  std::ostringstream why;
  why.precision(2);
  why << "100 κ u " << (plain ? "steps" : "√steps");
  if (condition != 1) why << ", κ = " << condition;
  return why.str();
}

std::vector<SceneDescription> every_way(const SceneDescription& description) {
  const SystemInfo& system = *catalogue().system(description.system);
  if (system.discrete) return {description};
  const Eigen::Map<const Eigen::VectorXd> lambda(
      description.inertia.data(), static_cast<Eigen::Index>(description.inertia.size()));
  std::vector<SceneDescription> all;
  for (const auto& on : system.methods) {
    if (on.takes && !on.takes(lambda)) continue;
    const MethodInfo& info = *catalogue().method(on.method);
    std::vector<std::optional<int>> orders = {std::nullopt};
    if (long_form()) orders.assign(info.orders.begin(), info.orders.end());
    if (orders.empty()) orders = {std::nullopt};
    for (const auto& order : orders)
      for (const char* arithmetic : {"compensated", "plain"}) {
        SceneDescription way = description;
        way.method = MethodDescription{std::string(on.method), order, {}, arithmetic};
        all.push_back(std::move(way));
      }
  }
  return all;
}

std::string Trial::outcome() const {
  if (!scene) return "REFUSED";
  switch (run_status.outcome) {
    case Outcome::reached:
      return "REACHED";
    case Outcome::left_domain:
      return "LEFT_DOMAIN";
    case Outcome::solver_stalled:
      return "SOLVER_STALLED";
    case Outcome::not_finite:
      return "NOT_FINITE";
    case Outcome::cancelled:
      return "CANCELLED";
  }
  return "";
}

std::string Trial::sentence() const {
  if (scene) return to_sentence(run_status, *scene);
  std::string all;
  for (const auto& v : refusals) all += v.field + " = " + v.value + ": " + v.rule + "; ";
  return all;
}

Trial run(const SceneDescription& description, std::int64_t steps) {
  Trial done;
  const double start = cpu_seconds();
  auto scene = Scene::resolve(description);
  if (scene) {
    done.scene = std::make_unique<Scene>(*std::move(scene));
    done.simulation = make_simulation(*done.scene);
    done.run_status = done.simulation->advance(steps);
  } else {
    done.refusals = std::move(scene.error());
  }
  done.seconds = cpu_seconds() - start;
  return done;
}

Record record_of(const std::string& extreme, const std::string& row,
                 const SceneDescription& description, const Trial& run) {
  Record r;
  r.extreme = extreme;
  r.row = row;
  r.system = description.system;
  if (description.method) {
    r.method = description.method->name;
    r.order = run.scene ? run.scene->order() : description.method->order.value_or(0);
    r.arithmetic = description.method->arithmetic;
  }
  r.outcome = run.outcome();
  r.seconds = run.seconds;
  return r;
}

}  // namespace stiefel::extremes

/// `--long FILE` runs the long form and `--short FILE` the short one; both write their records to
/// FILE. Without an option the short form is run and nothing is written.
int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (argc == 3) {
    const std::filesystem::path file = argv[2];
    std::filesystem::create_directories(file.parent_path());
    stiefel::extremes::whole = std::string(argv[1]) == "--long";
    stiefel::extremes::records.open(file);
    stiefel::extremes::records << "row\tmethod\toutcome\tmeasure\tvalue\tbound\tknown limit\ts\n";
  }
  return RUN_ALL_TESTS();
}
