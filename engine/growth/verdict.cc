#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/growth/confirmation.h"
#include "engine/numbers/to_text.h"

namespace stiefel {
namespace {

constexpr double ln2 = std::numbers::ln2;

std::string number(double x) { return to_text(x, 2); }

/// A count of blocks of which 16th parts can be told.
constexpr std::size_t least_blocks = 32;
/// A regular motion of fewer radians has not shown its growth by powers.
constexpr double least_turn = 500;
/// Growth by a power up to this one is regular, and a fall of GALI_2 up to that one.
constexpr double regular_power = 1.5, regular_fall = 6;
/// S_1 of a regular motion may exceed that power of the angle by so much: what one passage of an
/// unstable motion contributes.
constexpr double regular_offset = 8;
/// S_1 of a chaotic motion is so many times the most that a regular one may have. It rose by so
/// much in the last octave of means, and over three octaves at least like that power of the time,
/// which for growth in proportion to the time is 1.
constexpr double chaotic_excess = 2, chaotic_rise = 15, chaotic_power = 0.5, chaotic_fall = 8;
/// If the squared error of λ rises so much by the last doubling of batches, then these are hardly
/// longer than the correlations of the growth.
constexpr double correlated_rise = 1.5;
/// Beyond that fall of S_1 the vectors consist of rounding errors.
constexpr double rounding_fall = 25;
/// The part of the exponent that the confirmation must have.
constexpr double confirmed_part = 0.25;

double most_regular(double angle) { return regular_power * std::log1p(angle) + regular_offset; }

}  // namespace

Judgement judge_growth(const Growth& growth, double rate) {
  if (growth.blocks() < least_blocks)
    return {MotionKind::undecided, "Only " + std::to_string(growth.blocks()) +
                                       " intervals of growth: a verdict needs " +
                                       std::to_string(least_blocks) + "."};
  const double time = growth.time(), S = growth.sums()(0), angle = rate * time;
  const Growth::Levels a = growth.mean(0), b = growth.mean(1), c = growth.mean(2),
                       d = growth.mean(3);
  const double rise = a.first - b.first, before = b.first - c.first;
  const double power = (a.first - d.first) / (3 * ln2), last_power = rise / ln2;
  const double fall_2 = b.gali_2 - a.gali_2, fall_k = b.gali_k - a.gali_k;
  const Growth::BatchMeans means = growth.batch_means();
  const double lambda = S / time, error = means.errors(0) + std::log1p(angle) / time;
  const double regular_S = most_regular(angle);
  const bool many = growth.count() > 1;

  const std::string growths = "t·lambda(t) is " + number(S) + " at the end and rose by " +
                              number(rise) + " in the last doubling of the time, by " +
                              number(before) + " in the one before";
  const std::string volumes =
      many ? "; ln GALI_2 changed by " + number(-fall_2) +
                 (growth.count() > 2
                      ? " and ln GALI_" + std::to_string(growth.count()) + " by " + number(-fall_k)
                      : "") +
                 " in the last doubling"
           : "";

  const bool grows_by_power =
      last_power <= regular_power && power <= regular_power && S <= regular_S;
  if (grows_by_power && (!many || fall_2 <= regular_fall * ln2)) {
    if (angle < least_turn)
      return {MotionKind::undecided, growths + volumes + ", but the motion turned by " +
                                         number(angle) + " rad only: a verdict needs " +
                                         number(least_turn) + "."};
    return {
        MotionKind::regular,
        growths + ": growth like t^" + number(power) + volumes +
            ", like a power of t. Exponential growth in the last half of the time was at most " +
            number(std::max(rise, 0.0) / (0.375 * time)) + " a unit of time."};
  }
  const bool rises = rise >= chaotic_rise && S >= chaotic_excess * regular_S &&
                     a.first >= std::exp2(3 * chaotic_power) * d.first;
  const bool falls = !many || std::max(fall_2, fall_k) >= chaotic_fall;
  const std::string fell = "t·lambda(t) fell by up to " + number(growth.deepest_fall()) +
                           " on the way, so that the vectors had become rounding errors";
  if (rises && growth.deepest_fall() >= rounding_fall)
    return {MotionKind::undecided, growths + ", but " + fell + "."};
  const std::string correlated =
      means.last_rise >= correlated_rise
          ? ". Growth is correlated over spans as long as the longest batches, " +
                number(means.longest) + ": the squared error rose by a factor of " +
                number(means.last_rise) + " when they became so long, and may still be too small"
          : "";
  if (rises && falls && lambda > error)
    return {MotionKind::chaotic, growths + ": exponential over the whole run, with lambda = " +
                                     number(lambda) + " ± " + number(error) + volumes + correlated};
  return {MotionKind::undecided,
          growths + volumes +
              ": neither like a power of t nor, beyond the error of lambda = " + number(lambda) +
              " ± " + number(error) + ", exponential. A longer run may decide" + correlated + "."};
}

Judgement confirmed(const Judgement& found, const Growth& growth, const Growth& beside, double rate,
                    bool reached, const std::string& how, std::int64_t attempt) {
  const std::string neighbour =
      found.reason +
      (attempt == 0 ? ". A motion that starts " : ". The second of two motions that start ") +
      number(Confirmation::distance) + " beside this one" + (how.empty() ? "" : ", by " + how) +
      ",";
  if (!reached)
    return {MotionKind::undecided, neighbour + " ended early, so that it confirms nothing."};
  const double lambda = growth.sums()(0) / growth.time(), other = beside.sums()(0) / beside.time();
  const std::string numbers = neighbour + " has lambda = " + number(other) + " over the same time";
  const double least = chaotic_excess * most_regular(rate * beside.time());
  if (other >= confirmed_part * lambda && beside.sums()(0) >= least &&
      beside.deepest_fall() < rounding_fall)
    return {MotionKind::chaotic, numbers + "."};
  return {MotionKind::undecided,
          numbers + (how.empty() ? ": the growth is of this single motion, such as an unstable "
                                   "periodic one."
                                 : ": the growth is of the map, not of the flow, or of this single "
                                   "motion, such as an unstable periodic one.")};
}

}  // namespace stiefel
