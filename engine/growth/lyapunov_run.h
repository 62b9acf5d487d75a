#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "engine/growth/coordinates.h"
#include "engine/growth/growth.h"
#include "stiefel/linearization.h"
#include "stiefel/lyapunov.h"

namespace stiefel {

class Confirmation;

/// What `save` writes first. Of a run that goes on, the interval and the rate are those of its
/// start.
struct LyapunovHeader {
  /// The version of the bytes.
  static constexpr std::uint64_t format = 0x5354464c4c594134;

  std::uint64_t is = format;
  std::int64_t step = 0, interval = 0;
  double rate = 0, fastest = 0;
  std::array<std::int64_t, 4> asked{};  ///< what a request fixes

  void each(auto&& visit) {
    visit(is), visit(step), visit(interval), visit(rate), visit(fastest);
    for (auto& number : asked) visit(number);
  }

  static LyapunovHeader of(const LyapunovDescription& what) {
    return {.asked = {what.from, what.count, what.interval, static_cast<std::int64_t>(what.seed)}};
  }
  static LyapunovHeader read(ByteReader& in) {
    LyapunovHeader header;
    header.each([&](auto& number) { in.get(number); });
    return header;
  }
};

/// The run of a LyapunovExponents: the growth of vectors beside a motion, and after it, where its
/// verdict needs one, the confirmation.
class LyapunovRun final : public LyapunovExponents {
 public:
  /// The least number of vectors that move, where there are so many: GALI needs some.
  static constexpr std::int64_t least_vectors = 4;

  /// A run that is not judged has no verdict.
  LyapunovRun(const Scene& scene, const LyapunovDescription& what, bool judged = true);
  ~LyapunovRun() override;

  /// Returns what forbids the description, else an empty list. `saved`: of the run that goes on.
  Violations prepare(const Simulation& start, const std::optional<LyapunovHeader>& saved = {});
  /// Sets the random first vectors, unless the method has no tangent.
  Violations begin(const Simulation& start);
  /// Reads what stands behind the header.
  bool restore(ByteReader& in, const Simulation& now);

  std::string save() const override;
  RunStatus advance(Simulation& motion, std::int64_t steps, const std::stop_token& stop) override;
  bool done() const override { return ended_ || (at_ == what_.to && !confirmation_); }
  std::int64_t step() const override { return last_end_; }
  std::int64_t interval() const override { return interval_; }
  std::int64_t computed_steps() const override;
  std::int64_t covered_steps() const override;
  Eigen::VectorXd exponents() const override {
    return growth_.sums().head(shown()) / growth_.time();
  }
  Eigen::VectorXd errors() const override;
  Eigen::VectorXd log_gali() const override {
    return growth_.log_gali().head(std::max<Eigen::Index>(shown() - 1, 0));
  }
  MotionKind kind() const override { return judgement_.kind; }
  std::string reason() const override { return judgement_.reason; }

  const LyapunovDescription& what() const { return what_; }
  const Growth& growth() const { return growth_; }
  std::int64_t at() const { return at_; }
  std::int64_t interval_end() const { return std::min(what_.to, last_end_ + interval_); }

 private:
  /// Returns the number of exponents that are asked for.
  Eigen::Index shown() const {
    return what_.count > 0 ? static_cast<Eigen::Index>(what_.count) : count_;
  }
  /// Begins an interval with V at the state of `motion`.
  Violations restart(const Simulation& motion);
  /// Ends an interval.
  RunStatus close(const Simulation& motion);
  std::int64_t intervals() const { return (what_.to - what_.from - 1) / interval_ + 1; }
  void judge();
  /// Begins the confirmation, or goes on where it was saved. Returns why there is none.
  std::string begin_confirmation();
  RunStatus confirm(double steps, double step_cost, const std::stop_token& stop);
  std::string write() const;

  Scene scene_;
  LyapunovDescription what_;
  bool judged_;
  std::optional<GrowthVectors> vectors_;
  Eigen::Index count_ = 0;  ///< vectors that move; the largest exponents of them are shown
  std::int64_t interval_ = 1, at_ = 0, last_end_ = 0, computed_ = 0;
  double rate_ = 0, fastest_ = 0;  ///< of the motion: at the start, and the largest since
  std::vector<double> first_;      ///< the saved state at the start
  Dense V_;                        ///< at the last end of an interval
  Growth growth_;
  std::unique_ptr<Linearization> linearization_;
  std::string
      saved_;  ///< at the last end of a whole interval, while a shorter one runs and after it
  bool ended_ = false;
  Judgement judgement_;
  std::unique_ptr<Confirmation> confirmation_;
  std::vector<char> saved_confirmation_;         ///< when there is none, where a later run goes on
  std::int64_t attempt_ = 0, confirmed_to_ = 0;  ///< of the confirmation, and its last step
  std::int64_t computed_beside_ = 0;
};

}  // namespace stiefel
