#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/tangent/growth_vectors.h"
#include "engine/tangent/verdict.h"
#include "stiefel/linearization.h"
#include "stiefel/lyapunov.h"

namespace stiefel {

/// What `save` writes first. Of a run that goes on, the interval and the rate are those of its
/// start.
struct LyapunovHeader {
  /// The version of the bytes.
  static constexpr std::uint64_t format = 0x5354464c4c594132;

  std::uint64_t is = format;
  std::int64_t step = 0, from = 0, count = 0, asked_interval = 0, interval = 0;
  std::uint64_t seed = 0;
  double rate = 0;

  void each(auto&& visit) {
    visit(is), visit(step), visit(from), visit(count), visit(asked_interval), visit(interval);
    visit(seed), visit(rate);
  }

  /// Returns what a request fixes.
  static LyapunovHeader of(const LyapunovDescription& what);
};

/// The run of a LyapunovExponents.
class LyapunovRun {
  using Dense = Eigen::MatrixXd;

 public:
  /// A run that is not judged has no verdict.
  LyapunovRun(const Scene& scene, const LyapunovDescription& what, bool judged = true)
      : scene_(scene), what_(what), judged_(judged), growth_(1) {}

  /// Returns what forbids the description, else an empty list. `saved`: of the run that goes on.
  Violations prepare(const Simulation& start, const Place& place = {},
                     const std::optional<LyapunovHeader>& saved = {});
  /// Sets the random first vectors, unless the method has no tangent.
  Violations begin(const Simulation& start, const Place& place = {}) {
    V_ = vectors_->random(vectors_->state(start), count_, what_.seed);
    return restart(start, place);
  }
  /// Reads what stands behind the header.
  bool restore(ByteReader& in, const Simulation& now);
  std::string write() const;

  RunStatus advance(Simulation& motion, std::int64_t steps, const std::stop_token& stop);
  bool done() const { return ended_ || (at_ == what_.to && !beside_); }

  const LyapunovDescription& what() const { return what_; }
  const Growth& growth() const { return growth_; }
  Eigen::Index shown() const {
    return what_.count > 0 ? static_cast<Eigen::Index>(what_.count) : count_;
  }
  std::int64_t at() const { return at_; }
  std::int64_t interval() const { return interval_; }
  std::int64_t last_end() const { return last_end_; }
  std::int64_t computed() const {
    return computed_ + computed_beside_ + (beside_ ? beside_->computed_ : 0);
  }
  double rate() const { return rate_; }
  const Judgement& judgement() const { return judgement_; }
  const std::string& saved() const { return saved_; }

 private:
  std::int64_t interval_end() const { return std::min(what_.to, last_end_ + interval_); }
  /// Begins an interval with V at the state of `motion`.
  Violations restart(const Simulation& motion, const Place& place = {});
  /// Ends an interval.
  RunStatus close(const Simulation& motion);
  void judge(const Simulation& motion);
  /// Returns the scene of a second motion, beside that state.
  std::optional<Scene> beside(const Simulation& start) const;
  RunStatus advance_beside(std::int64_t steps, const std::stop_token& stop);

  Scene scene_;
  LyapunovDescription what_;
  bool judged_;
  std::optional<GrowthVectors> vectors_;
  Eigen::Index count_ = 0;  ///< vectors that move; the largest exponents of them are shown
  std::int64_t interval_ = 1, at_ = 0, last_end_ = 0, computed_ = 0, computed_beside_ = 0;
  double rate_ = 0;
  Dense V_;  ///< at the last end of an interval
  Growth growth_;
  std::optional<Linearization> linearization_;
  std::string
      saved_;  ///< at the last end of a whole interval, while a shorter one runs and after it
  bool ended_ = false;
  Judgement judgement_;
  std::unique_ptr<Simulation> other_;
  std::unique_ptr<LyapunovRun> beside_;
};

}  // namespace stiefel
