#include "server/convert/diagnose_task.h"

#include <algorithm>
#include <concepts>
#include <utility>

#include "engine/scene/near_name.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/catalogue.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

constexpr std::uint32_t default_pairs = 8, max_symplectic_pairs = 1000;
constexpr int largest_symplectic = 32;
constexpr std::uint32_t default_invariants = 4096, max_invariants = 8192;
/// The most invariants, forms and brackets, each, that a request may name.
constexpr int max_asked = 10'000;
/// The most blocks of a tangent vector: more than any system has.
constexpr std::size_t max_blocks = 64;

std::string near_invariant(const Scene& scene, const std::string& name) {
  const SystemInfo& system = *catalogue().system(scene.system());
  return did_you_mean(name, system.invariants, &InvariantInfo::name);
}

/// Reads matrices and collects the violations of a request.
class DiagnoseReader {
 public:
  template <class Text>
  void refuse(const Path& path, const Text& text) {
    faults_.add(path, text);
  }
  void refuse(const Path& path, std::string value, std::string rule) {
    faults_.add(path, std::move(value), std::move(rule));
  }
  void at_most(const char* field, std::integral auto count, std::integral auto most) {
    if (std::cmp_greater(count, most))
      faults_.add(field, std::to_string(count), "must be at most " + std::to_string(most));
  }
  template <class Map>
  TangentVector vector(const Path& path, const Map& given) {
    TangentVector out;
    if (given.size() > max_blocks) {
      refuse(path, std::to_string(given.size()) + " blocks",
             "must be at most " + std::to_string(max_blocks));
      return out;
    }
    for (const auto& [name, value] : given) {
      stop_point();
      RowMatrix read = matrix(Path(path, name), value);
      if (sound()) out[name] = std::move(read);
    }
    return out;
  }
  template <class Functions>
  PairFactors factors(const Path& path, const Functions& given) {
    PairFactors out;
    for (int i = 0; i < given.size(); ++i) {
      stop_point();
      const Path at(path, i);
      RowMatrix A = matrix(Path(at, "A"), given[i].a()), B = matrix(Path(at, "B"), given[i].b());
      if (sound()) out.factors.emplace_back(std::move(A), std::move(B));
    }
    return out;
  }
  bool sound() const { return faults_.empty(); }
  grpc::Status refusal() { return errors::invalid(faults_.take()); }

 private:
  RowMatrix matrix(const Path& path, const v1::Matrix& given) {
    return read_matrix(path, given, faults_).value_or(RowMatrix());
  }

  Faults faults_{in_the_request};
};

}  // namespace

OrStatus<DiagnoseTask> DiagnoseTask::read(const Session& session,
                                          const v1::DiagnoseRequest& request) {
  const Scene& scene = session.scene();
  DiagnoseTask task;
  DiagnoseReader in;
  in.at_most("invariants", request.invariants_size(), max_asked);
  in.at_most("forms", request.forms_size(), max_asked);
  in.at_most("dirac_brackets", request.dirac_brackets_size(), max_asked);
  const auto alone = [&](const char* field, bool asked) {
    if (asked && !scene.members().empty())
      in.refuse(field, std::to_string(scene.members().size()) + " members",
                "the scene must have no `members`: two-forms and brackets are evaluated for single "
                "scenes");
  };
  alone("forms", request.forms_size() > 0);
  alone("dirac_brackets", request.dirac_brackets_size() > 0);
  alone("symplectic_test", request.has_symplectic_test());
  if (!in.sound()) return std::unexpected(in.refusal());
  const Path invariants("invariants"), forms("forms"), brackets("dirac_brackets");
  for (int i = 0; i < request.invariants_size(); ++i) {
    stop_point();
    const std::string& name = request.invariants(i);
    if (!is_invariant(scene, name))
      in.refuse(Path(invariants, i), [&] {
        return std::pair(name,
                         "must be an invariant of " + scene.system() + near_invariant(scene, name));
      });
    if (in.sound()) task.invariants_.push_back(name);
  }
  for (int i = 0; i < request.forms_size(); ++i) {
    stop_point();
    const auto& form = request.forms(i);
    const Path path(forms, i);
    task.forms_.push_back({form.form(), in.vector(Path(path, "first"), form.first()),
                           in.vector(Path(path, "second"), form.second())});
  }
  for (int i = 0; i < request.dirac_brackets_size(); ++i) {
    stop_point();
    const auto& bracket = request.dirac_brackets(i);
    const Path path(brackets, i);
    task.brackets_.push_back({in.factors(Path(path, "first"), bracket.first()),
                              in.factors(Path(path, "second"), bracket.second())});
  }
  if (request.has_symplectic_test()) {
    task.symplectic_ = request.symplectic_test();
    const std::uint32_t pairs = task.symplectic_->pairs();
    in.at_most("symplectic_test.pairs", pairs, max_symplectic_pairs);
    if (pairs == 0) task.symplectic_->set_pairs(default_pairs);
    if (const int N = whole_dimension(scene); N > largest_symplectic)
      in.refuse("symplectic_test", "N = " + std::to_string(N),
                "is for N up to " + std::to_string(largest_symplectic));
  }
  task.estimate_error_ = request.estimate_error();
  if (!v1::ErrorEstimation_IsValid(task.estimate_error_))
    in.refuse("estimate_error", std::to_string(task.estimate_error_),
              "must be a value of stiefel.v1.ErrorEstimation");
  in.at_most("max_invariants", request.max_invariants(), max_invariants);
  task.max_invariants_ =
      request.max_invariants() > 0 ? request.max_invariants() : default_invariants;
  if (!in.sound()) return std::unexpected(in.refusal());
  return task;
}

}  // namespace stiefel::server
