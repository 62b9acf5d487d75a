#include "engine/conversion/conversion_of_members.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

ConversionRefusal of_member(ConversionRefusal refusal, std::size_t b) {
  if (auto* violations = std::get_if<Violations>(&refusal)) {
    for (Violation& one : *violations) one.value += " (member " + std::to_string(b) + ")";
  } else {
    std::get<OutsideDomain>(refusal).member = static_cast<std::int64_t>(b);
  }
  return refusal;
}

/// Stacks matrices of equal shape, one of each member.
class Stack {
 public:
  explicit Stack(std::size_t members) : members_(static_cast<Eigen::Index>(members)) {}

  void put(std::size_t b, const auto& matrix) {
    if (matrix.size() == 0) return;
    if (rows_.size() == 0) rows_.resize(members_ * matrix.rows(), matrix.cols());
    rows_.middleRows(static_cast<Eigen::Index>(b) * matrix.rows(), matrix.rows()) = matrix;
  }
  RowMatrix take() { return std::move(rows_); }

 private:
  Eigen::Index members_;
  RowMatrix rows_;
};

/// Collects the converted members.
class Together {
 public:
  Together(const Scene& ensemble, const ConversionTarget& target)
      : ensemble_(ensemble),
        system_(catalogue().system(target.name)),
        count_(ensemble.members().size()) {
    if (system_ == nullptr || target.epsilon) return;
    for (const auto& block : system_->blocks) takes_M_ = takes_M_ || block.name == "M";
  }

  void put(std::size_t b, const Conversion& one) {
    keep_smallest(one.margins);
    for (const auto& [name, block] : one.blocks) stack(values_, name).put(b, block);
    if (!one.scene) return;
    const SceneDescription& d = one.scene->description();
    for (const auto& [name, block] : d.initial) {
      stack(values_, name).put(b, block.values);
      stack(imaginary_, name).put(b, block.imaginary);
    }
    inertia_.insert(inertia_.end(), d.inertia.begin(), d.inertia.end());
    if (d.epsilon) epsilons_.push_back(*d.epsilon);
    parameter_ = d.parameter;
    if (takes_M_ && d.epsilon) M_.put(b, make_simulation(*one.scene)->get("M"));
  }

  /// Whether the members have chosen different ε.
  bool own_epsilons() const {
    return std::ranges::adjacent_find(epsilons_, std::not_equal_to()) != epsilons_.end();
  }
  bool takes_M() const { return takes_M_; }
  /// Returns the ε of least absolute value, which keeps all members in the domain.
  double least_epsilon() const {
    return *std::ranges::min_element(epsilons_, {}, [](double x) { return std::abs(x); });
  }
  std::vector<Margin> margins() { return std::move(margins_); }

  std::map<std::string, Eigen::MatrixXd> blocks() {
    std::map<std::string, Eigen::MatrixXd> out;
    for (auto& [name, stacked] : values_) out.emplace(name, stacked.take());
    return out;
  }

  SceneDescription description() {
    SceneDescription out;
    out.system = system_->name;
    out.method = method_on(*system_, ensemble_);
    out.members = static_cast<int>(count_);
    out.step = ensemble_.step();
    out.parameter = parameter_;
    out.inertia = common_or_all();
    for (auto& [name, stacked] : values_)
      out.initial.emplace(name, Block(stacked.take(), stack(imaginary_, name).take()));
    if (own_epsilons()) {  // M replaces P, so that each member chooses its ε again
      out.initial.erase("P");
      out.initial["M"] = Block(M_.take());
    } else if (!epsilons_.empty()) {
      out.epsilon = epsilons_.front();
    }
    return out;
  }

 private:
  Stack& stack(std::map<std::string, Stack>& of, const std::string& name) const {
    return of.try_emplace(name, count_).first->second;
  }
  void keep_smallest(const std::vector<Margin>& ones) {
    for (const Margin& one : ones) {
      const auto found = std::ranges::find(margins_, one.domain, &Margin::domain);
      if (found == margins_.end())
        margins_.push_back(one);
      else
        found->margin = std::min(found->margin, one.margin);
    }
  }
  /// Returns the inertia of one member if all have the same, else that of all in turn.
  std::vector<double> common_or_all() const {
    const std::size_t each = inertia_.size() / count_;
    for (std::size_t k = each; k < inertia_.size(); ++k)
      if (inertia_[k] != inertia_[k - each]) return inertia_;
    return {inertia_.begin(), inertia_.begin() + static_cast<std::ptrdiff_t>(each)};
  }

  const Scene& ensemble_;
  const SystemInfo* system_;
  std::size_t count_;
  bool takes_M_ = false;
  std::map<std::string, Stack> values_, imaginary_;
  Stack M_{count_};
  std::vector<double> inertia_, epsilons_;
  std::optional<double> parameter_;
  std::vector<Margin> margins_;
};

}  // namespace

std::expected<Conversion, ConversionRefusal> convert_members(const Scene& ensemble,
                                                             const ConversionTarget& target) {
  const auto members = ensemble.members();
  Together together(ensemble, target);
  for (std::size_t b = 0; b < members.size(); ++b) {
    stop_point();
    auto one = convert(members[b], target);
    if (!one) return std::unexpected(of_member(std::move(one.error()), b));
    together.put(b, *one);
  }
  if (together.own_epsilons() && !together.takes_M()) {
    ConversionTarget in_common = target;
    in_common.epsilon = together.least_epsilon();
    return convert_members(ensemble, in_common);
  }
  Conversion out;
  out.margins = together.margins();
  if (catalogue().system(target.name) == nullptr) {
    out.blocks = together.blocks();
    return out;
  }
  auto made =
      resolve_recommending(together.description(), Scene::frame_tolerance, place_of_result(target));
  if (!made) return std::unexpected(ConversionRefusal(std::move(made.error())));
  out.scene = *std::move(made);
  return out;
}

}  // namespace stiefel
