#include <utility>

#include "engine/scene/near_name.h"
#include "server/convert/convert.h"
#include "server/convert/diagnose_task.h"
#include "server/convert/errors.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/catalogue.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

constexpr std::uint32_t default_pairs = 8, max_symplectic_pairs = 1000;
constexpr int largest_symplectic = 32;
/// The most invariants, forms and brackets, each, that a request may name.
constexpr int max_asked = 10'000;
/// The most blocks of a tangent vector: more than any system has.
constexpr std::size_t max_blocks = 64;

TangentVector vector_of(const google::protobuf::Map<std::string, v1::Matrix>& given,
                        const Path& path, Faults& faults) {
  TangentVector out;
  if (!faults.at_most(path, given.size(), max_blocks)) return out;
  for (const auto& [name, value] : given) {
    stop_point();
    out[name] = read_matrix(Path(path, name), value, faults);
  }
  return out;
}

PairFactors factors_of(const google::protobuf::RepeatedPtrField<v1::LinearFunction>& given,
                       const Path& path, Faults& faults) {
  PairFactors out;
  for (int i = 0; i < given.size(); ++i) {
    stop_point();
    const Path at(path, i);
    RowMatrix A = read_matrix(Path(at, "A"), given[i].a(), faults);
    out.factors.emplace_back(std::move(A), read_matrix(Path(at, "B"), given[i].b(), faults));
  }
  return out;
}

}  // namespace

DiagnoseTask read(const Session& session, const v1::DiagnoseRequest& request) {
  const Scene& scene = session.scene();
  DiagnoseTask task;
  Faults faults(in_the_request);
  faults.at_most("invariants", request.invariants_size(), max_asked);
  faults.at_most("forms", request.forms_size(), max_asked);
  faults.at_most("dirac_brackets", request.dirac_brackets_size(), max_asked);
  const auto alone = [&](const char* field, bool asked) {
    if (asked && !scene.members().empty())
      faults.add(field, std::to_string(scene.members().size()) + " members",
                 "the scene must have no `members`: two-forms and brackets are evaluated for "
                 "single scenes");
  };
  alone("forms", request.forms_size() > 0);
  alone("dirac_brackets", request.dirac_brackets_size() > 0);
  alone("symplectic_test", request.has_symplectic_test());
  check(faults);
  const Path invariants("invariants"), forms("forms"), brackets("dirac_brackets");
  for (int i = 0; i < request.invariants_size(); ++i) {
    stop_point();
    const std::string& name = request.invariants(i);
    if (!is_invariant(scene, name))
      faults.add(Path(invariants, i), [&] {
        const SystemInfo& system = *catalogue().system(scene.system());
        return std::pair(name, "must be an invariant of " + scene.system() +
                                   did_you_mean(name, system.invariants, &InvariantInfo::name));
      });
    task.invariants.push_back(name);
  }
  for (int i = 0; i < request.forms_size(); ++i) {
    const auto& form = request.forms(i);
    const Path path(forms, i);
    task.forms.push_back({form.form(), vector_of(form.first(), Path(path, "first"), faults),
                          vector_of(form.second(), Path(path, "second"), faults)});
  }
  for (int i = 0; i < request.dirac_brackets_size(); ++i) {
    const auto& bracket = request.dirac_brackets(i);
    const Path path(brackets, i);
    task.brackets.push_back({factors_of(bracket.first(), Path(path, "first"), faults),
                             factors_of(bracket.second(), Path(path, "second"), faults)});
  }
  if (request.has_symplectic_test()) {
    task.symplectic = request.symplectic_test();
    const std::uint32_t pairs = task.symplectic->pairs();
    faults.at_most("symplectic_test.pairs", pairs, max_symplectic_pairs);
    if (pairs == 0) task.symplectic->set_pairs(default_pairs);
    if (const int N = whole_dimension(scene); N > largest_symplectic)
      faults.add("symplectic_test", "N = " + std::to_string(N),
                 "is for N up to " + std::to_string(largest_symplectic));
  }
  task.estimate_error = request.estimate_error();
  if (!v1::ErrorEstimation_IsValid(task.estimate_error))
    faults.add("estimate_error", std::to_string(task.estimate_error),
               "must be a value of stiefel.v1.ErrorEstimation");
  check(faults);
  return task;
}

}  // namespace stiefel::server
