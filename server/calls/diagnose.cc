#include <cmath>

#include "engine/linalg/arithmetic/to_text.h"
#include "engine/simulation/scene/near_name.h"
#include "server/calls/cursor_call.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/requests.h"
#include "stiefel/catalogue.h"
#include "stiefel/diagnosis.h"
#include "stiefel/error_estimate.h"

namespace stiefel::server {
namespace {

constexpr std::uint32_t default_pairs = 8, max_pairs = 1000;
constexpr int largest_symplectic = 32;
/// Units of work that an estimate of the error may take: about ten seconds.
constexpr double most_estimate_work = 5e10;

struct Form {
  std::string name;
  TangentVector first, second;
};
struct Bracket {
  PairFactors first, second;
};

/// What a Diagnose asks for, once its shapes are checked.
struct DiagnoseTask {
  std::vector<std::string> invariants;
  std::vector<Form> forms;
  std::vector<Bracket> brackets;
  std::optional<v1::SymplecticTest> symplectic;
  v1::ErrorEstimation estimate_error = v1::ERROR_ESTIMATION_UNSPECIFIED;
  Violations violations;

  /// What has no slices is no work for the pool of steps.
  bool takes_long() const {
    return estimate_error != v1::ERROR_ESTIMATION_UNSPECIFIED || symplectic ||
           !invariants.empty() || !forms.empty() || !brackets.empty();
  }
  void take(Violations more) { violations.insert(violations.end(), more.begin(), more.end()); }
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

template <class Index>
std::string indexed(const char* field, Index i) {
  return std::string(field) + "[" + std::to_string(i) + "]";
}

std::string near_invariant(const Scene& scene, const std::string& name) {
  const SystemInfo& system = *catalogue().system(scene.system());
  return did_you_mean(name, system.invariants, &InvariantInfo::name);
}

DiagnoseTask read(const Scene& scene, const v1::DiagnoseRequest& request) {
  DiagnoseTask task;
  for (int i = 0; i < request.invariants_size(); ++i) {
    const std::string& name = request.invariants(i);
    if (!is_invariant(scene, name))
      task.take({{indexed("invariants", i), name,
                  "must be an invariant of " + scene.system() + near_invariant(scene, name)}});
    task.invariants.push_back(name);
  }
  for (int i = 0; i < request.forms_size(); ++i) {
    const auto& form = request.forms(i);
    const std::string path = indexed("forms", i);
    task.forms.push_back({form.form(), task.vector(path + ".first", form.first()),
                          task.vector(path + ".second", form.second())});
  }
  for (int i = 0; i < request.dirac_brackets_size(); ++i) {
    const auto& bracket = request.dirac_brackets(i);
    const std::string path = indexed("dirac_brackets", i);
    task.brackets.push_back({task.factors(path + ".first", bracket.first()),
                             task.factors(path + ".second", bracket.second())});
  }
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
  return task;
}

/// The value of an element of a list, or why there is none.
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

grpc::Status answer_diagnose(const Session& at, const Cursor& cursor, const DiagnoseTask& task,
                             const std::stop_token& stop, v1::DiagnoseResponse* response) {
  const Scene& scene = at.scene();
  const Simulation& now = cursor.simulation();
  to_proto(cursor, scene, response->mutable_run_status());
  response->set_step(cursor.step());
  response->set_time(scene.time(cursor.step()));
  response->set_computed_steps(cursor.computed_steps());
  to_proto(diagnose(scene, now, task.invariants, stop), response);
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
  return grpc::Status::OK;
}

}  // namespace

grpc::ServerUnaryReactor* Service::Diagnose(Context* context, const v1::DiagnoseRequest* request,
                                            v1::DiagnoseResponse* response) {
  CallLog log(host_.log, *context, "Diagnose", request->session_id());
  const auto refuse = [&](const grpc::Status& status) {
    log.finish(status);
    auto* reactor = context->DefaultReactor();
    reactor->Finish(status);
    return reactor;
  };
  try {
    auto session = find_session(host_, request->session_id());
    if (!session) return refuse(session.error());
    if (const auto status = check_step("to", request->to()); !status.ok()) return refuse(status);
    DiagnoseTask task = read((*session)->scene(), *request);
    if (!task.violations.empty()) return refuse(errors::invalid(task.violations));
    const std::int64_t to = request->to();
    if (task.takes_long())
      return new CursorCall(
          host_, std::move(log), *std::move(session), to,
          [task = std::move(task), response](const Session& at, const Cursor& cursor,
                                             const std::stop_token& stop) {
            return answer_diagnose(at, cursor, task, stop, response);
          });
    return new CursorCall(
        host_, std::move(log), *std::move(session), to,
        [task = std::move(task), response](const Session& at, const Cursor& cursor) {
          return answer_diagnose(at, cursor, task, {}, response);
        });
  } catch (...) {
    return refuse(errors::from_current_exception());
  }
}

}  // namespace stiefel::server
