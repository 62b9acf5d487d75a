#include "engine/summary/plan.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "engine/numbers/to_text.h"
#include "engine/scene/near_name.h"
#include "stiefel/catalogue.h"
#include "stiefel/price.h"

namespace stiefel {
namespace {

constexpr std::size_t most_violations = 16;
/// Most numbers of states at times between two consecutive steps, over all members: 64 MiB.
constexpr std::size_t most_between_steps = std::size_t{1} << 23;
/// A time that is a multiple of the step up to this relative error is the time of that step. Time
/// and step are doubles, each of which may be rounded twice: 1.7 is step 17 of 0.1.
constexpr long double rounding_of_steps = 0x1p-51L;

std::string at(const char* list, std::size_t i, const char* field = "") {
  return std::string(list) + "[" + std::to_string(i) + "]" + field;
}

class Check {
 public:
  Check(const Scene& scene, const Simulation& start, Plan& plan)
      : scene_(scene),
        start_(start),
        plan_(plan),
        members_(std::max<std::size_t>(1, scene.members().size())) {
    if (!scene.members().empty()) first_ = scene.members().front();
  }

  Violations run() {
    for (std::size_t i = 0; i < plan_.what.quantities.size() && !full(); ++i) quantity(i);
    for (std::size_t i = 0; i < plan_.what.events.size() && !full(); ++i) event(i);
    fields();
    times();
    sizes();
    return std::move(violations_);
  }

 private:
  void refuse(std::string field, std::string value, std::string rule) {
    violations_.push_back({std::move(field), std::move(value), std::move(rule)});
  }
  /// Whether enough is said: the loops over what the caller gives end.
  bool full() const { return violations_.size() >= most_violations; }
  std::optional<Field> field(const std::string& name) const {
    const auto index = find_field(start_.fields(), name);
    return index ? std::optional(field_at(start_.fields(), *index)) : std::nullopt;
  }
  /// Returns the rule for the name of a field, or of a quantity: a field or an invariant.
  std::string rule_of_names(const std::string& given, bool of_quantity = false) const {
    const std::string rule = "must be one of " + field_names(start_.fields()),
                      near_field = did_you_mean(given, start_.fields(), &Field::name);
    if (!of_quantity) return rule + near_field;
    const auto& invariants = catalogue().system(scene_.system())->invariants;
    return rule + ", or the invariants " + listed(invariants, &InvariantInfo::name) +
           (near_field.empty() ? did_you_mean(given, invariants, &InvariantInfo::name)
                               : near_field);
  }

  void quantity(std::size_t i) {
    const Quantity& asked = plan_.what.quantities[i];
    Plan::Read read;
    auto reading = make_reading(first_ ? *first_ : scene_, start_, asked.name);
    if (!reading) {
      refuse(at("quantities", i, ".name"), asked.name, rule_of_names(asked.name, true));
      plan_.reads.push_back(read);
      return;
    }
    if (!seen_.insert(asked.name).second)
      refuse(at("quantities", i, ".name"), asked.name, "is named twice");
    read.size = reading->size();
    read.shape = reading->shape();
    const auto of = field(asked.name);
    read.complex = of && of->complex;
    statistics(i, asked, read);
    if (!first_ || (of && !read.drift)) read.common = std::move(reading);
    read.first = plan_.last_size;
    plan_.last_size += read.size;
    plan_.reads_on_the_way = plan_.reads_on_the_way || read.on_the_way;
    plan_.reads.push_back(std::move(read));
  }

  void statistics(std::size_t i, const Quantity& asked, Plan::Read& read) {
    if (asked.statistics.empty() && asked.quantiles.empty() && asked.edges.empty())
      refuse(at("quantities", i, ".statistics"), "none",
             "must be given where there are no quantiles and no edges");
    std::set<Statistic> seen;
    for (const Statistic statistic : asked.statistics) {
      if (full()) return;
      if (!seen.insert(statistic).second)
        refuse(at("quantities", i, ".statistics"), asked.name, "names a statistic twice");
      if (statistic != Statistic::last) read.on_the_way = true;
      if (statistic == Statistic::drift) read.drift = true;
      if (statistic == Statistic::last && asked.over_members)
        refuse(at("quantities", i, ".over_members"), "true",
               "must be false with `last`, which exists for each member only");
      if (read.complex && statistic != Statistic::last && statistic != Statistic::mean)
        refuse(at("quantities", i, ".statistics"), asked.name,
               "is a complex field, which has `last` and `mean` only");
    }
    if (read.complex && !(asked.quantiles.empty() && asked.edges.empty()))
      refuse(at("quantities", i, ".name"), asked.name,
             "is a complex field, which has `last` and `mean` only");
    if (!asked.quantiles.empty() || !asked.edges.empty()) read.on_the_way = true;
    for (const double q : asked.quantiles)
      if (!full() && !(q >= 0 && q <= 1))
        refuse(at("quantities", i, ".quantiles"), to_text(q), "must be 0 to 1");
    bool increasing = asked.edges.size() != 1;
    for (std::size_t k = 0; k < asked.edges.size(); ++k)
      increasing = increasing && std::isfinite(asked.edges[k]) &&
                   (k == 0 || asked.edges[k - 1] < asked.edges[k]);
    if (!increasing)
      refuse(at("quantities", i, ".edges"), to_text(asked.edges),
             "must be two or more finite numbers, each larger than the one before");
  }

  void event(std::size_t i) {
    const EventDescription& asked = plan_.what.events[i];
    bool any = false;
    double angle = 0;  // the coefficients of angles that jump by 2π
    const std::string place = at("events", i);
    if (!term(place, asked.field, asked.coefficients, any, angle)) return;
    for (std::size_t k = 0; k < asked.plus.size(); ++k)
      if (!term(place + at(".plus", k), asked.plus[k].field, asked.plus[k].coefficients, any,
                angle))
        return;
    if (asked.extremum && plan_.discrete)
      refuse(place + ".extremum", "true",
             "must be false: " + scene_.system() +
                 " is a discrete system, which has no derivative along its motion");
    if (!std::isfinite(asked.level))
      refuse(place, asked.field, "coefficients and level must be finite");
    else if (!any)
      refuse(place + ".coefficients", to_text(asked.coefficients), "must not all be 0");
  }

  /// Returns whether the term of an event is sound. Sets `any` where a coefficient is not 0, and
  /// `angle` to the absolute value of one of an angle that jumps by 2π.
  bool term(const std::string& place, const std::string& name,
            const std::vector<double>& coefficients, bool& any, double& angle) {
    const std::size_t before = violations_.size();
    const auto of = field(name);
    if (!of)
      refuse(place + ".field", name, rule_of_names(name));
    else if (of->complex)
      refuse(place + ".field", name, "must be a real field");
    else if (const auto size = static_cast<std::size_t>(of->size()); coefficients.size() != size)
      refuse(place + ".coefficients", std::to_string(coefficients.size()) + " numbers",
             "must be " + std::to_string(size) + ", one for each element of " + name);
    else if (!std::ranges::all_of(coefficients, [](double c) { return std::isfinite(c); }))
      refuse(place, name, "coefficients and level must be finite");
    any = any || std::ranges::any_of(coefficients, [](double c) { return c != 0; });
    if (violations_.size() > before || !of->angles) return violations_.size() == before;
    for (const double c : {std::abs(coefficients[0]), std::abs(coefficients[2])}) {
      if (angle != 0 && c != 0 && c != angle)
        refuse(place + ".coefficients", to_text(c),
               "must be 0 or, without its sign, " + to_text(angle) +
                   ", as for the other angle that jumps by 2π");
      if (c != 0) angle = c;
    }
    return violations_.size() == before;
  }

  void fields() {
    const auto& named = plan_.what.fields;
    std::set<std::string> seen;
    for (std::size_t i = 0; i < named.size() && !full(); ++i) {
      const auto of = find_field(start_.fields(), named[i]);
      if (!of)
        refuse(at("fields", i), named[i], rule_of_names(named[i]));
      else if (!seen.insert(named[i]).second)
        refuse(at("fields", i), named[i], "is named twice");
      else
        plan_.fields.push_back(*of);
    }
    if (named.empty()) plan_.fields = default_fields(scene_, start_.fields(), start_.block_count());
    for (const std::size_t index : plan_.fields)
      plan_.state_size += field_size(start_.fields(), index);
  }

  void times() {
    const auto& given = plan_.what.times;
    if (given.empty()) return;
    std::size_t together = 0;
    for (std::size_t i = 0; i < given.size(); ++i) {
      if (!time(i, given[i])) return;
      const bool same = i > 0 && plan_.times[i].arrival == plan_.times[i - 1].arrival;
      together = same ? together + 1 : 1;
      if (together > 1 && together * plan_.state_size * members_ > most_between_steps)
        return refuse(at("times", i), to_text(given[i]),
                      "the states between two steps may have at most " +
                          std::to_string(most_between_steps) + " numbers; give fewer times");
    }
  }

  /// Adds the time of index i to the plan. Returns false when a violation makes further checks
  /// meaningless.
  bool time(std::size_t i, double t) {
    const auto& what = plan_.what;
    long double steps = static_cast<long double>(t) / scene_.step();
    const long double nearest = std::nearbyint(steps);
    if (std::abs(steps - nearest) <= rounding_of_steps * nearest) steps = nearest;
    if (!std::isfinite(t) || !(steps >= what.from && steps <= what.to)) {
      refuse(at("times", i), to_text(t),
             "must be " + to_text(scene_.time(what.from)) + " to " + to_text(scene_.time(what.to)) +
                 (steps < 0 ? "; for this time, use a step of the other sign" : ""));
      return false;
    }
    const auto before = static_cast<std::int64_t>(std::floor(steps));
    const auto fraction = static_cast<double>(steps - static_cast<long double>(before));
    if (plan_.discrete && fraction > 0) {
      refuse(at("times", i), to_text(t),
             "must be a whole number of steps of " + to_text(scene_.step()) + ": " +
                 scene_.system() + " is a discrete system, whose states are at its steps only");
      return false;
    }
    plan_.times.push_back({before, before + (fraction > 0), fraction});
    const auto position = [&](std::size_t k) {
      return std::pair(plan_.times[k].before, plan_.times[k].fraction);
    };
    if (i == 0 || position(i - 1) <= position(i)) return true;
    refuse(at("times", i), to_text(t), "must not be earlier in the motion than the previous time");
    return false;
  }

  void sizes() {
    if (!violations_.empty()) return;
    const auto samples = static_cast<std::uint64_t>(plan_.samples());
    long double kept = 0, numbers = 0;
    for (std::size_t i = 0; i < plan_.reads.size(); ++i) {
      const Quantity& asked = plan_.what.quantities[i];
      const long double elements =
          static_cast<long double>(plan_.reads[i].size) * static_cast<long double>(members_);
      if (!asked.quantiles.empty()) kept += elements * static_cast<long double>(samples);
      numbers += elements * static_cast<long double>(asked.statistics.size() +
                                                     asked.quantiles.size() + asked.edges.size());
    }
    const auto text = [](long double x) { return to_text(static_cast<double>(x)); };
    if (kept > Summary::max_kept)
      refuse("quantities", text(kept) + " values",
             "quantiles are exact and keep at most " + std::to_string(Summary::max_kept) +
                 " values: take fewer samples, or a histogram");
    if (numbers > Summary::max_numbers)
      refuse("quantities", text(numbers) + " numbers",
             "a summary has at most " + std::to_string(Summary::max_numbers) +
                 " numbers: name fewer, or set over_members");
    if (members_ * plan_.state_size > Summary::max_numbers &&
        !(plan_.what.events.empty() && plan_.what.times.empty()))
      refuse("fields", std::to_string(members_ * plan_.state_size) + " numbers",
             "must have at most " + std::to_string(Summary::max_numbers) + ": name fewer fields");
  }

  const Scene& scene_;
  std::optional<Scene> first_;  ///< the first member
  const Simulation& start_;
  Plan& plan_;
  std::size_t members_;
  std::set<std::string> seen_;
  Violations violations_;
};

}  // namespace

std::expected<Plan, Violations> make_plan(const Scene& scene, const Simulation& start,
                                          SummaryDescription what) {
  for (const auto& [field, count, most] :
       {std::tuple("quantities", what.quantities.size(), Summary::max_quantities),
        std::tuple("events", what.events.size(), Summary::max_events),
        std::tuple("times", what.times.size(), Summary::max_times)})
    if (count > most)
      return std::unexpected(
          Violations{{field, std::to_string(count), "must be at most " + std::to_string(most)}});
  Plan plan;
  plan.what = std::move(what);
  plan.discrete = catalogue().system(scene.system())->discrete;
  plan.step_size = scene.step();
  Violations violations = Check(scene, start, plan).run();
  if (!violations.empty()) return std::unexpected(std::move(violations));
  return plan;
}

}  // namespace stiefel
