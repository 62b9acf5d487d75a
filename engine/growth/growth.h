#pragma once

#include <string>
#include <vector>

#include "engine/numbers/byte_stream.h"
#include "engine/numbers/scalar.h"
#include "stiefel/lyapunov.h"

namespace stiefel {

/// What the upper triangular factors R of orthonormalisations tell about the growth of k vectors:
/// sums, their batches, and the volume of the vectors. Times are durations, > 0.
class Growth {
 public:
  using Numbers = Eigen::VectorXd;

  explicit Growth(Eigen::Index k);

  /// Adds an interval after which the orthonormal vectors of before have become V = QR, r_ii > 0.
  void add(double duration, const Dense& R);

  Eigen::Index count() const { return sums_.size(); }
  double time() const { return time_; }
  const Numbers& sums() const { return sums_; }
  /// Returns ln GALI_2 … ln GALI_k.
  Numbers log_gali() const;
  struct BatchMeans {
    Numbers errors;        ///< half-widths of 95 % intervals of sums / time
    double last_rise = 1;  ///< of the squared error of S_1 / time from the last doubling of batches
    double longest = 0;    ///< the time of the longest batches
  };
  /// Blocking [FlyvbjergPetersen1989]: v_m is the squared standard error of sums / time from
  /// batches of m blocks, m = 1, 2, 4, … M with at least 8 batches. It rises with m until the
  /// batches are longer than the correlations of the growth. Where it rose, it is taken to rise
  /// like the same power of m for as many doublings again, which is up to about the whole run:
  ///
  ///     error = max(max_m t_m √v_m, t_M √(v_M · v_M / v_1)),
  ///
  /// t_m the 97.5 % point of Student's distribution for that number of batches. Infinite below 16
  /// intervals.
  BatchMeans batch_means() const;
  /// The largest fall of S_1 from a value that it had before.
  double deepest_fall() const { return deepest_fall_; }

  /// What is followed over the time: S_1, ln GALI_2, ln GALI_k.
  struct Levels {
    double first = 0, gali_2 = 0, gali_k = 0;
  };
  /// Returns their means over (T/2, T], (T/4, T/2], (T/8, T/4], (T/16, T/8] for j = 0 … 3, T the
  /// time at the last full block; there must be 16 blocks.
  Levels mean(int j) const;
  std::size_t blocks() const { return blocks_.size(); }

  void save(ByteWriter& out) const;
  void restore(ByteReader& in);

 private:
  /// Some intervals in a row.
  struct Block {
    double time = 0;
    Eigen::Vector3d levels;  ///< Levels times the duration
    Numbers growth;
  };
  /// The most blocks. Then every two become one, so that there are at least half as many.
  static constexpr std::size_t most_blocks = 128;

  /// Returns the squares of the standard errors of sums / time from batches of so many blocks.
  Numbers squared_error(std::size_t blocks_a_batch) const;
  void close_block();
  /// Visits all numbers but that of blocks.
  template <class Self, class Visit>
  static void each(Self& self, const Visit& visit);

  Numbers sums_;
  double time_ = 0, highest_ = 0, deepest_fall_ = 0;
  /// The vectors that are not orthonormalised: directions in terms of the orthonormal ones, a unit
  /// vector a column, and the logarithms of their lengths.
  Dense directions_;
  Numbers lengths_;
  std::vector<Block> blocks_;
  Block open_;
  std::uint64_t block_length_ = 1, open_length_ = 0;  ///< in intervals
};

/// What the growth of tangent vectors says of a motion, and why.
struct Judgement {
  MotionKind kind = MotionKind::undecided;
  std::string reason = "The motion has not reached the last step.";
};

/// Judges by four means over the last octaves of time, whatever the unit: how the largest growth
/// S_1 rises (by a constant a doubling: regular; over three octaves at least like √t, and to far
/// beyond c ln t: chaotic), how GALI falls (by a power, or exponentially), and whether S_1 fell so
/// far that rounding decides. `rate`: that of the motion at its start, 1/time.
Judgement judge_growth(const Growth& growth, double rate);

/// Returns what remains of the judgement `found`, "chaotic", with the growth of a confirmation,
/// which is incomplete if not `reached`: it must exceed a regular motion's as far. `how`: its map,
/// empty if it is that of a discrete system. `attempt`: 0 or 1.
Judgement confirmed(const Judgement& found, const Growth& growth, const Growth& beside, double rate,
                    bool reached, const std::string& how, std::int64_t attempt);

}  // namespace stiefel
