#include "engine/accuracy/search.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stiefel {
namespace {

/// A point is useful if it at least halves the error. After `patience` points in a row that are
/// not, the candidate has no more points.
constexpr double useful_ratio = 0.5;
constexpr int patience = 2;

/// Whether errors are useful after those of a longer step, as far as both runs went. Errors as
/// large as the quantity itself do not yet fall with the step.
bool is_useful(const std::vector<double>& before, const std::vector<double>& now) {
  const std::size_t n = std::min(before.size(), now.size());
  return n == 0 || now[n - 1] > saturated_error || now[n - 1] <= useful_ratio * before[n - 1];
}

}  // namespace

std::expected<PointSearch, Violations> PointSearch::prepare(const SceneDescription& description,
                                                            double budget) {
  if (description.members && *description.members > TradeoffRequest::most_members)
    return std::unexpected(Violations{Violation{
        "members", std::to_string(*description.members),
        "must be at most " + std::to_string(TradeoffRequest::most_members) +
            " where methods are measured, which keeps the reference of each; give a method"}});
  auto scenes = motions_of(description);
  if (!scenes) return std::unexpected(std::move(scenes.error()));
  auto found = stiefel::candidates(scenes->front());
  if (!found) return std::unexpected(std::move(found.error()));
  PointSearch search(*std::move(scenes), budget);
  for (Candidate& one : *found)
    if (search.motions_.take(one.method)) {
      one.weight *= static_cast<double>(search.motions_.count());
      search.curves_.push_back({std::move(one)});
    }
  return search;
}

void PointSearch::solve_references(std::int64_t steps, Density density, double share,
                                   bool quadruple, const std::stop_token& stop) {
  steps_ = steps;
  const double time = std::abs(motions_.front().time(steps_));
  motions_.solve_references(steps_, density, {time, share * left_, quadruple}, stop);
  left_ -= samples().work;
}

void PointSearch::leave_out(const std::function<bool(const Candidate&)>& which) {
  std::erase_if(curves_, [&](const Curve& curve) { return which(curve.candidate); });
}

std::vector<Candidate> PointSearch::candidates() const {
  std::vector<Candidate> all;
  for (const Curve& curve : curves_) all.push_back(curve.candidate);
  return all;
}

double PointSearch::least_cost(const Curve& curve) const {
  const Candidate& candidate = curve.candidate;
  const double of_one = candidate.weight * static_cast<double>(steps_);
  return candidate.own_steps ? std::max(of_one, curve.cost) : of_one * std::ldexp(1, curve.r);
}

double PointSearch::least_cost() const {
  double least = infinity;
  for (const Curve& curve : curves_) least = std::min(least, least_cost(curve));
  return least;
}

std::optional<Point> PointSearch::next(const RunBounds& bounds, double times) {
  while (!curves_.empty()) {
    stop_point();
    const auto cost = [this](const Curve& curve) { return least_cost(curve); };
    const auto curve = std::ranges::min_element(curves_, {}, cost);
    auto point = measure(curve->candidate, *curve->candidate.refined(curve->r), bounds, times);
    if (bounds.stop.stop_requested()) return std::nullopt;
    if (!point) {
      curves_.erase(curve);
      continue;
    }
    // A tighter tolerance may not change the steps yet, or not those of a run that ended early.
    const bool another = point->cost != std::exchange(curve->cost, point->cost);
    if (another && (!curve->candidate.own_steps || point->run.steps >= bounds.to)) {
      auto course = point->run.course();
      const bool useful = is_useful(curve->course, course);
      curve->useless = useful ? 0 : curve->useless + 1;
      if (useful) curve->course = std::move(course);
    }
    if (curve->useless >= patience || !curve->candidate.refined(++curve->r)) curves_.erase(curve);
    if (another) return point;
  }
  return std::nullopt;
}

std::optional<Point> PointSearch::measure(const Candidate& candidate,
                                          const MethodDescription& method, RunBounds bounds,
                                          double times) {
  if (candidate.in_float()) bounds.to = steps_;
  const auto& steps = samples().steps;
  const auto compared =
      static_cast<double>(std::ranges::upper_bound(steps, bounds.to) - steps.begin());
  const bool jumps = candidate.is_closed_form() && bounds.watch == Watch::errors;
  const double states = jumps ? compared : static_cast<double>(bounds.to);
  double takes = times * (states * candidate.weight * method.substeps.value_or(1) +
                          compared * static_cast<double>(motions_.count()) *
                              comparison_work(motions_.front()));
  std::optional<Run> run;
  if (takes <= left_) {
    bounds.most_work = left_;
    run = motions_.run(method, candidate.weight, bounds, hardest_);
    left_ -= run->spent;
    takes = std::max(takes, run->spent);
  }
  if (!run || run->status.outcome == Outcome::cancelled) {
    too_dear_ = std::min(too_dear_, takes);
    return std::nullopt;
  }
  hardest_ = run->member;
  const double rest = static_cast<double>(steps_) / static_cast<double>(run->steps);
  const double cost = run->steps > 0 ? run->work * rest : 0;
  return Point{candidate, *motions_.front().with(method).value().description().method,
               *std::move(run), cost};
}

Run PointSearch::again(const Point& point, const std::stop_token& stop) {
  Run run =
      motions_.run(point.method, point.candidate.weight, {point.run.steps, Watch::time, stop});
  left_ -= run.spent;
  return run;
}

std::vector<std::size_t> pareto_front(const std::vector<CostAndError>& points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](std::size_t i, std::size_t j) {
    const auto &a = points[i], &b = points[j];
    return a.cost < b.cost || (a.cost == b.cost && a.error < b.error);
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order)
    if (front.empty() ? !std::isnan(points[i].error) : points[i].error < points[front.back()].error)
      front.push_back(i);
  return front;
}

}  // namespace stiefel
