#include "engine/accuracy/chooser.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/numbers/to_text.h"
#include "engine/scene/members.h"

namespace stiefel {
namespace {

/// Share of the remaining budget for choosing; the rest is for measuring the members.
constexpr double choosing_share = 1.0 / 4;
constexpr int most_rounds = 8;
constexpr std::size_t most_new_pilots = 4;
static_assert(1 + most_new_pilots * most_rounds == Choice::most_pilots);

/// Whether the method is that of the entry, up to its substeps or its tolerance.
bool is_entry(const Candidate& entry, const MethodDescription& method) {
  return entry.method.name == method.name && entry.method.order == method.order &&
         entry.method.arithmetic == method.arithmetic && entry.method.scalar == method.scalar;
}

class MembersChooser {
 public:
  MembersChooser(const SceneDescription& description, const Place& place, const Scene& ensemble)
      : description_(description), place_(place), members_(ensemble.members()) {}

  std::expected<Choice, Violations> choose();

 private:
  /// Returns the indices of the members by Simulation::rate at the start, the fastest first.
  std::vector<std::size_t> fastest_first() const;
  /// Measures the chosen method, which is of that entry, on the members that are no pilots. Returns
  /// true once all are measured, or enough members are found that miss the tolerance (`missed_`);
  /// false where the budget does not suffice. Raises error and cost of `chosen` to those of all
  /// members.
  bool measure_others(const Candidate& entry, Chooser::Trial& chosen);
  Violation refusal(std::string rule) const;
  Violations of_pilots(Violations violations) const;

  const SceneDescription& description_;
  const Place& place_;
  const Members members_;
  std::vector<std::size_t> order_, pilots_, missed_;
  std::optional<std::size_t> worst_;  ///< the member with the largest error, where it is known
  double left_ = Choice::most_work;
};

std::vector<std::size_t> MembersChooser::fastest_first() const {
  std::vector<double> rates;
  rates.reserve(members_.size());
  for (const Scene& member : members_) {
    stop_point();
    rates.push_back(make_simulation(member)->rate());
  }
  std::vector<std::size_t> order(members_.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t b) { return rates[b]; });
  return order;
}

Violation MembersChooser::refusal(std::string rule) const {
  Violation out = place_.violation("tolerance", to_text(*description_.tolerance), std::move(rule));
  out.reason = "TOLERANCE_NOT_MET";
  out.metadata = {{"tolerance", to_text(*description_.tolerance)},
                  {"most_work", to_text(Choice::most_work)}};
  return out;
}

Violations MembersChooser::of_pilots(Violations violations) const {
  std::string names;
  for (const std::size_t b : pilots_) names += (names.empty() ? "" : ", ") + std::to_string(b);
  for (Violation& one : violations)
    one.value += (pilots_.size() > 1 ? " (members " : " (member ") + names + ")";
  return violations;
}

bool MembersChooser::measure_others(const Candidate& entry, Chooser::Trial& chosen) {
  std::vector<std::size_t> others;
  std::ranges::copy_if(order_, std::back_inserter(others), [&](std::size_t b) {
    return std::ranges::find(pilots_, b) == pilots_.end();
  });
  missed_.clear();
  double largest = chosen.error;
  worst_ = pilots_.size() == 1 ? std::optional(pilots_.front()) : std::nullopt;
  for (std::size_t k = 0; k < others.size() && missed_.size() < most_new_pilots; ++k) {
    stop_point();
    const Scene member = members_[others[k]];
    if (!member.with(chosen.method)) {
      missed_.push_back(others[k]);
      continue;
    }
    Chooser one(description_, place_, MeasuredMotions({member}), {entry},
                left_ / static_cast<double>(others.size() - k));
    const auto trial = one.measure(chosen.method);
    left_ -= one.work();
    if (!trial && description_.verification == "optional") {
      chosen.verified = false;
      return true;
    }
    if (!trial) return false;
    if (!trial->good()) missed_.push_back(others[k]);
    chosen.cost += trial->cost;
    chosen.steps = std::min(chosen.steps, trial->steps);
    if (trial->error > largest) {
      largest = trial->error;
      worst_ = others[k];
    }
  }
  chosen.error = largest;
  return true;
}

std::expected<Choice, Violations> MembersChooser::choose() {
  order_ = fastest_first();
  pilots_ = {order_.front()};
  for (int round = 0; round < most_rounds; ++round) {
    std::vector<Scene> scenes;
    for (const std::size_t b : pilots_) scenes.push_back(members_[b]);
    MeasuredMotions motions(std::move(scenes));
    auto own = candidates(member_of(description_, static_cast<int>(pilots_.front())), place_);
    if (!own) return std::unexpected(of_pilots(std::move(own.error())));
    auto all = taken_by_all(own->all, motions);
    if (all.empty())
      return std::unexpected(
          of_pilots({refusal("cannot be met: no method accepts all of these members")}));
    const bool alone = pilots_.size() == members_.size();
    Chooser chooser(description_, place_, std::move(motions), std::move(all),
                    alone ? left_ : choosing_share * left_);
    auto chosen = chooser.choose();
    left_ -= chooser.work();
    if (!chosen) return std::unexpected(of_pilots(std::move(chosen.error())));
    const auto entry = std::ranges::find_if(
        own->all, [&](const Candidate& one) { return is_entry(one, chosen->method); });
    if (!measure_others(*entry, *chosen))
      return std::unexpected(Violations{
          refusal("cannot be checked in each of " + std::to_string(members_.size()) +
                  " members within the " + short_text(Choice::most_work) +
                  " instructions that a choice may take; give a method, fewer members, or " +
                  "\"verification\": \"optional\"")});
    if (missed_.empty())
      return Choice{chosen->method,
                    *description_.tolerance,
                    *description_.horizon,
                    chosen->error * *description_.tolerance,
                    chosen->verified,
                    chooser.reason(*chosen) + "; the largest error of " +
                        std::to_string(members_.size()) + " members" +
                        (worst_ ? ", in member " + std::to_string(*worst_) : "") +
                        (chosen->verified ? "" : "; not verified in every member"),
                    Choice::most_work - left_};
    pilots_.insert(pilots_.end(), missed_.begin(), missed_.end());
  }
  return std::unexpected(
      of_pilots({refusal("cannot be met in every member: after " + std::to_string(most_rounds) +
                         " choices some members still miss it; give a method")}));
}

}  // namespace

std::expected<Choice, Violations> choose_for_members(const SceneDescription& description,
                                                     const Place& place) {
  const auto ensemble = with_recommended_method(description, place);
  if (!ensemble) return std::unexpected(ensemble.error());
  return MembersChooser(description, place, *ensemble).choose();
}

}  // namespace stiefel
