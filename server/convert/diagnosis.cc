#include "server/convert/diagnosis.h"

#include <algorithm>
#include <cmath>

#include "engine/linalg/arithmetic/to_text.h"
#include "engine/simulation/scene/near_name.h"
#include "proto/checksum/checksum.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/price.h"
#include "stiefel/catalogue.h"
#include "stiefel/diagnosis.h"
#include "stiefel/error_estimate.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

constexpr std::uint32_t default_pairs = 8, max_pairs = 1000;
constexpr int largest_symplectic = 32;
constexpr std::uint32_t default_invariants = 4096, max_invariants = 8192;
/// The most invariants, forms and brackets, each, that a request may name.
constexpr int max_asked = 10'000;
/// The most work of an error estimate, in instructions: about ten seconds.
constexpr double most_estimate_work = 5e10;
/// Above this dimension, or this number of members or of forms and brackets, a Diagnose is more
/// than a slice of work.
constexpr int small_dimension = 16;
constexpr std::size_t few = 16;

struct Form {
  std::string name;
  TangentVector first, second;
};
struct Bracket {
  PairFactors first, second;
};

template <class Index>
std::string indexed(const char* field, Index i) {
  return std::string(field) + "[" + std::to_string(i) + "]";
}

std::string near_invariant(const Scene& scene, const std::string& name) {
  const SystemInfo& system = *catalogue().system(scene.system());
  return did_you_mean(name, system.invariants, &InvariantInfo::name);
}

}  // namespace

struct DiagnoseTask::Parts {
  std::vector<std::string> invariants;
  std::vector<Form> forms;
  std::vector<Bracket> brackets;
  std::optional<v1::SymplecticTest> symplectic;
  bool large = false;  ///< the scene is so large that each invariant is work
  v1::ErrorEstimation estimate_error = v1::ERROR_ESTIMATION_UNSPECIFIED;
  std::size_t max_invariants = default_invariants;
  bool checksum = false;
  Violations violations;

  void take(Violations more) { violations.insert(violations.end(), more.begin(), more.end()); }
  void at_most(const char* field, int count, int most) {
    if (count > most)
      take({{field, std::to_string(count), "must be at most " + std::to_string(most)}});
  }
  RowMatrix matrix(const std::string& path, const v1::Matrix& given) {
    auto block = from_proto(path, given);
    if (block) return block->values;
    take(block.error());
    return {};
  }
  template <class Map>
  TangentVector vector(const std::string& path, const Map& given) {
    TangentVector out;
    for (const auto& [name, value] : given) out[name] = matrix(path + "." + name, value);
    return out;
  }
  template <class Functions>
  PairFactors factors(const std::string& path, const Functions& given) {
    PairFactors out;
    for (int i = 0; i < given.size(); ++i) {
      const std::string at = path + "[" + std::to_string(i) + "]";
      out.factors.emplace_back(matrix(at + ".A", given[i].a()), matrix(at + ".B", given[i].b()));
    }
    return out;
  }
};

DiagnoseTask::DiagnoseTask(std::shared_ptr<const Parts> parts) : parts_(std::move(parts)) {}
DiagnoseTask::DiagnoseTask(DiagnoseTask&&) noexcept = default;
DiagnoseTask::~DiagnoseTask() = default;

OrStatus<DiagnoseTask> DiagnoseTask::read(const Session& session,
                                          const v1::DiagnoseRequest& request) {
  const Scene& scene = session.scene();
  const auto parts = std::make_shared<Parts>();
  Parts& task = *parts;
  task.at_most("invariants", request.invariants_size(), max_asked);
  task.at_most("forms", request.forms_size(), max_asked);
  task.at_most("dirac_brackets", request.dirac_brackets_size(), max_asked);
  if (!task.violations.empty()) return std::unexpected(errors::invalid(task.violations));
  for (int i = 0; i < request.invariants_size(); ++i) {
    const std::string& name = request.invariants(i);
    if (!is_invariant(scene, name))
      task.take({{indexed("invariants", i), name,
                  "must be an invariant of " + scene.system() + near_invariant(scene, name)}});
    task.invariants.push_back(name);
  }
  for (int i = 0; i < request.forms_size(); ++i) {
    stop_point();
    const auto& form = request.forms(i);
    const std::string path = indexed("forms", i);
    task.forms.push_back({form.form(), task.vector(path + ".first", form.first()),
                          task.vector(path + ".second", form.second())});
  }
  for (int i = 0; i < request.dirac_brackets_size(); ++i) {
    stop_point();
    const auto& bracket = request.dirac_brackets(i);
    const std::string path = indexed("dirac_brackets", i);
    task.brackets.push_back({task.factors(path + ".first", bracket.first()),
                             task.factors(path + ".second", bracket.second())});
  }
  task.large = scene.dimension() > small_dimension || scene.members().size() > few;
  if (request.has_symplectic_test()) {
    task.symplectic = request.symplectic_test();
    const std::uint32_t pairs = task.symplectic->pairs();
    if (pairs > max_pairs)
      task.take({{"symplectic_test.pairs", std::to_string(pairs),
                  "must be at most " + std::to_string(max_pairs)}});
    if (pairs == 0) task.symplectic->set_pairs(default_pairs);
    if (scene.dimension() > largest_symplectic)
      task.take({{"symplectic_test", "N = " + std::to_string(scene.dimension()),
                  "is for N up to " + std::to_string(largest_symplectic)}});
  }
  task.estimate_error = request.estimate_error();
  if (!v1::ErrorEstimation_IsValid(task.estimate_error))
    task.take({{"estimate_error", std::to_string(task.estimate_error),
                "must be a value of stiefel.v1.ErrorEstimation"}});
  if (request.max_invariants() > max_invariants)
    task.take({{"max_invariants", std::to_string(request.max_invariants()),
                "must be at most " + std::to_string(max_invariants)}});
  if (request.max_invariants() > 0) task.max_invariants = request.max_invariants();
  task.checksum = request.checksum();
  if (!task.violations.empty()) return std::unexpected(errors::invalid(task.violations));
  return DiagnoseTask(parts);
}

bool DiagnoseTask::takes_long() const {
  const Parts& task = *parts_;
  return task.estimate_error != v1::ERROR_ESTIMATION_UNSPECIFIED || task.symplectic || task.large ||
         task.forms.size() + task.brackets.size() > few;
}

namespace {

/// Whether a request asks for an invariant of `family`; `unasked` if it names no invariant at all.
bool asks_for(const std::vector<std::string>& invariants, std::string_view family, bool unasked) {
  if (invariants.empty()) return unasked;
  return std::ranges::any_of(invariants,
                             [&](const std::string& name) { return name.starts_with(family); });
}

}  // namespace

double DiagnoseTask::work(const Session& session) const {
  // Matrix products for the norms, Casimirs and momenta of two states, for a form, and for a
  // bracket.
  constexpr double of_state = 200, of_form = 40, of_bracket = 250, steps_of_pair = 12;
  const Parts& task = *parts_;
  const Scene& scene = session.scene();
  const double N = scene.dimension(), product = N * N * N;
  double of_each = of_state * product;
  if (asks_for(task.invariants, "manakov", N <= small_dimension)) of_each += N * N * product;
  double work = of_each * std::max(1.0, static_cast<double>(scene.members().size()));
  work += static_cast<double>(task.forms.size()) * of_form * product;
  for (const Bracket& bracket : task.brackets)
    work += of_bracket * product +
            static_cast<double>(bracket.first.factors.size() + bracket.second.factors.size()) * 6 *
                N * N;
  if (task.symplectic) work += steps_of_pair * task.symplectic->pairs() * session.work(0, 1);
  if (task.estimate_error != v1::ERROR_ESTIMATION_UNSPECIFIED) work += most_estimate_work;
  return work;
}

namespace {

/// Returns the value if it is finite, otherwise an error for the element at `path`.
OrStatus<double> number(const std::string& path, std::expected<double, Violations> value) {
  if (!value) return std::unexpected(errors::invalid(value.error()));
  if (!std::isfinite(*value))
    return std::unexpected(
        errors::invalid(path, to_text(*value), "overflows: its arguments are too large"));
  return *value;
}

void estimate(const Scene& scene, const Simulation& now, v1::ErrorEstimation asked,
              const std::stop_token& stop, v1::EstimatedError* out) {
  const double budget = asked == v1::ERROR_ESTIMATION_IF_CHEAPER
                            ? std::min(run_work(scene, now), most_estimate_work)
                            : most_estimate_work;
  to_proto(estimate_error(scene, now, budget, stop), out);
}

std::string family_of(const std::string& invariant) {
  return invariant.substr(0, invariant.find('['));
}

/// Keeps, of each family, the at most `most` invariants with the largest drifts, in their order.
void shorten(std::size_t most, std::vector<InvariantDrift>& invariants,
             v1::DiagnoseResponse* response) {
  std::map<std::string, std::vector<double>> drifts;
  for (const InvariantDrift& invariant : invariants)
    drifts[family_of(invariant.name)].push_back(-invariant.drift());
  for (auto& [family, values] : drifts) {
    if (values.size() <= most) continue;
    auto* shortened = response->add_shortened();
    shortened->set_name(family);
    shortened->set_count(values.size());
    std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(most) - 1);
    const double least = -values[most - 1];
    std::size_t kept = 0;
    std::erase_if(invariants, [&](const InvariantDrift& invariant) {
      return family_of(invariant.name) == family && (invariant.drift() < least || kept++ >= most);
    });
  }
}

}  // namespace

grpc::Status DiagnoseTask::answer(const Session& session, const Cursor& cursor,
                                  const std::stop_token& stop,
                                  v1::DiagnoseResponse* response) const {
  const Parts& task = *parts_;
  const Scene& scene = session.scene();
  const Simulation& now = cursor.simulation();
  to_proto(cursor, scene, response->mutable_run_status());
  response->set_step(cursor.step());
  response->set_time(scene.time(cursor.step()));
  response->set_computed_steps(cursor.computed_steps());
  to_proto(session.work(cursor.start(), cursor.step()) + work(session), 0, bound_of_steps(session),
           response->mutable_price());
  response->mutable_price()->set_memory_bytes(session.simulation_bytes() / 2 * 3);
  Diagnosis diagnosis = diagnose(scene, now, task.invariants, stop);
  shorten(task.max_invariants, diagnosis.invariants, response);
  to_proto(diagnosis, response);
  for (std::size_t i = 0; i < task.forms.size() && !stop.stop_requested(); ++i) {
    const auto& [name, first, second] = task.forms[i];
    const std::string path = indexed("forms", i);
    const auto value =
        number(path, evaluate_form(scene, now, name, first, second, Place::inside(path)));
    if (!value) return value.error();
    response->add_forms(*value);
  }
  for (std::size_t i = 0; i < task.brackets.size() && !stop.stop_requested(); ++i) {
    const auto& [first, second] = task.brackets[i];
    const std::string path = indexed("dirac_brackets", i);
    const auto value = number(path, dirac_bracket(scene, now, first, second, Place::inside(path)));
    if (!value) return value.error();
    response->add_dirac_brackets(*value);
  }
  if (task.symplectic) {
    const auto defect =
        symplectic_defect(scene, now, static_cast<int>(task.symplectic->pairs()),
                          task.symplectic->seed(), Place::inside("symplectic_test"), stop);
    if (!defect) return errors::invalid(defect.error());
    if (*defect) response->set_symplectic_defect(**defect);
  }
  if (task.estimate_error != v1::ERROR_ESTIMATION_UNSPECIFIED)
    estimate(scene, now, task.estimate_error, stop, response->mutable_estimated_error());
  if (task.checksum) {
    response->set_checksum(wire::checksum(*response));
    response->set_details_checksum(wire::details_checksum(*response));
  }
  return grpc::Status::OK;
}

}  // namespace stiefel::server
