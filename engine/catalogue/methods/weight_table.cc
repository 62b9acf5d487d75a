#include "engine/catalogue/methods/weight_table.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace stiefel {
namespace {

constexpr Weight weights[] = {
#include "engine/catalogue/methods/step_weights.inc"
};

/// A point of a curve of counts.
struct At {
  double x, instructions;
};

/// Number of lanes of a register. Products of matrices take more instructions where a size is not a
/// multiple of it.
constexpr double lanes = 4;

/// Interpolates by a power law between the points next to x. Uses only points with the same
/// remainder modulo `lanes` as x if there are such points on both sides of x, else all points.
/// Beyond the points returns the last one times `scale(x, x_i)`.
template <class Scale>
double interpolate(const std::vector<At>& points, double x, const Scale& scale) {
  for (const bool alike : {true, false}) {
    const At *below = nullptr, *above = nullptr;
    for (const At& point : points) {
      if (alike && std::fmod(point.x, lanes) != std::fmod(x, lanes)) continue;
      if (point.x <= x) below = &point;
      if (point.x >= x && !above) above = &point;
    }
    if (below && below->x == x) return below->instructions;
    if (alike && !(below && above)) continue;
    if (!below || !above) {
      const At& last = below ? *below : *above;
      return last.instructions * scale(x, last.x);
    }
    const double share = std::log(x / below->x) / std::log(above->x / below->x);
    return below->instructions * std::pow(above->instructions / below->instructions, share);
  }
  return 0;  // no points
}

}  // namespace

double operations(double n, double N) { return n * n * N + n * n * n + 8 * n * N; }

std::span<const Weight> weight_table() { return weights; }

const Weight* find_weight(std::string_view system, std::string_view method, int order,
                          std::string_view arithmetic, std::string_view scalar) {
  const auto found = std::ranges::find_if(weights, [&](const Weight& w) {
    return w.system == system && w.method == method && w.order == order &&
           w.arithmetic == arithmetic && w.scalar == scalar;
  });
  return found == std::end(weights) ? nullptr : found;
}

// Interpolates along N for each n of the table, then along n; only along N = n where the table has
// only such sizes.
double instructions_at(const Weight& weight, double n, double N) {
  const auto& sizes = weight.sizes;
  std::vector<At> curve;
  if (n == N && std::ranges::all_of(sizes, [](const Counted& at) { return at.n == at.N; })) {
    for (const Counted& at : sizes) curve.push_back({at.n, at.instructions});
    return interpolate(
        curve, n, [](double x, double last) { return operations(x, x) / operations(last, last); });
  }
  for (const Counted* at = sizes.begin(); at != sizes.end();) {
    const double rows = at->n;
    std::vector<At> along;
    for (; at != sizes.end() && at->n == rows; ++at) along.push_back({at->N, at->instructions});
    const auto scale = [rows](double x, double last) {
      return operations(rows, x) / operations(rows, last);
    };
    curve.push_back({rows, interpolate(along, N, scale)});
  }
  return interpolate(curve, n,
                     [N](double x, double last) { return operations(x, N) / operations(last, N); });
}

double rate_factor(const Weight& weight, double N, double h_omega) {
  const std::span<const AtRate> rates(weight.rates);
  if (rates.empty() || !(h_omega > 0)) return 1;
  double dimension = rates.front().N;
  for (const AtRate& rate : rates)
    if (rate.N <= N) dimension = rate.N;
  const AtRate *below = nullptr, *above = nullptr;
  for (const AtRate& rate : rates) {
    if (rate.N != dimension) continue;
    if (rate.h_omega <= h_omega) below = &rate;
    if (rate.h_omega >= h_omega && !above) above = &rate;
  }
  if (!below || !above || below == above) return (below ? below : above)->factor;
  const double share =
      std::log(h_omega / below->h_omega) / std::log(above->h_omega / below->h_omega);
  return below->factor * std::pow(above->factor / below->factor, share);
}

}  // namespace stiefel
