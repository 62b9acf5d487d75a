#include "engine/summary/member.h"

#include <optional>

namespace stiefel {
namespace {

/// The names of the statistics, in the order of Statistic.
constexpr const char* statistic_names[] = {"last", "min",          "max",  "mean",
                                           "rms",  "sign_changes", "drift"};

template <class Numbers>
void append(auto& all, const Numbers& some) {
  all.insert(all.end(), some.begin(), some.end());
}

class Results {
 public:
  Results(const Plan& plan, std::span<const Member* const> members, bool ensemble)
      : plan_(plan), members_(members), ensemble_(ensemble) {}

  std::vector<SummaryArray> all() {
    for (std::size_t q = 0; q < plan_.reads.size(); ++q) quantity(q);
    const auto count = [&](const char* name, auto value) {
      SummaryArray& out = add(name, SummaryArray::Type::count, {}, ensemble_);
      for (const Member* member : members_) out.counts.push_back(value(*member->end));
    };
    count("outcome",
          [](const MemberEnd& end) { return static_cast<std::int64_t>(end.status.outcome); });
    count("last_step", [](const MemberEnd& end) { return end.last_step; });
    count("ended_by", [](const MemberEnd& end) { return end.ended_by; });
    count("samples", [&](const MemberEnd& end) { return samples(end.last_step); });
    return std::move(arrays_);
  }

 private:
  std::int64_t samples(std::int64_t last) const {
    const std::int64_t steps = last - plan_.what.from;
    return steps < 0 ? 1 : steps / plan_.what.every + 1 + (steps % plan_.what.every > 0);
  }

  SummaryArray& add(std::string name, SummaryArray::Type type, std::vector<std::size_t> shape,
                    bool by_members) {
    if (by_members) shape.insert(shape.begin(), members_.size());
    return arrays_.emplace_back(SummaryArray{std::move(name), std::move(shape), type, {}, {}});
  }

  void quantity(std::size_t q) {
    const Quantity& asked = plan_.what.quantities[q];
    const Plan::Read& read = plan_.reads[q];
    const bool over = asked.over_members && ensemble_;
    std::optional<Accumulators> all;
    std::vector<const Accumulators*> of;
    for (const Member* member : members_) {
      if (!plan_.reads_on_the_way) break;  // there are no accumulators
      const Accumulators& one = member->accumulators[q];
      if (over && all)
        all->merge(one);
      else if (over)
        of = {&all.emplace(one)};
      else
        of.push_back(&one);
    }
    const auto real = read.complex ? SummaryArray::Type::complex : SummaryArray::Type::real;
    const bool by_members = ensemble_ && !over;
    for (const Statistic statistic : asked.statistics) {
      const bool counts = statistic == Statistic::sign_changes;
      SummaryArray& out =
          add(asked.name + "." + statistic_names[static_cast<std::size_t>(statistic)],
              counts ? SummaryArray::Type::count : real, read.shape, by_members);
      if (statistic == Statistic::last)
        for (const Member* member : members_) append(out.numbers, plan_.last(member->last, q));
      else
        for (const Accumulators* one : of)
          counts ? append(out.counts, one->sign_changes())
                 : append(out.numbers, one->result(statistic));
    }
    const auto behind = [&](std::size_t extent) {
      auto shape = read.shape;
      shape.push_back(extent);
      return shape;
    };
    if (!asked.quantiles.empty()) {
      SummaryArray& out =
          add(asked.name + ".quantiles", real, behind(asked.quantiles.size()), by_members);
      for (const Accumulators* one : of) append(out.numbers, one->quantiles());
    }
    if (!asked.edges.empty()) {
      SummaryArray& out = add(asked.name + ".histogram", SummaryArray::Type::count,
                              behind(asked.edges.size() - 1), by_members);
      for (const Accumulators* one : of) append(out.counts, one->histogram());
    }
  }

  const Plan& plan_;
  const std::span<const Member* const> members_;
  const bool ensemble_;
  std::vector<SummaryArray> arrays_;
};

}  // namespace

std::vector<SummaryArray> results(const Plan& plan, std::span<const Member* const> members,
                                  bool ensemble) {
  return Results(plan, members, ensemble).all();
}

std::uint64_t result_bytes(const Plan& plan, std::size_t members) {
  std::uint64_t numbers = 4 * members;
  for (std::size_t q = 0; q < plan.reads.size(); ++q) {
    const Quantity& asked = plan.what.quantities[q];
    const std::size_t bins = asked.edges.empty() ? 0 : asked.edges.size() - 1;
    numbers += (asked.statistics.size() + asked.quantiles.size() + bins) * plan.reads[q].size *
               (asked.over_members ? 1 : members);
  }
  return numbers * sizeof(double);
}

}  // namespace stiefel
