#include "server/convert/tangents/lyapunov_answer.h"

#include <algorithm>
#include <utility>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

static_assert(same_order(MotionKind::chaotic, v1::VERDICT_UNDECIDED) == v1::VERDICT_CHAOTIC);

void put(const Eigen::VectorXd& numbers, google::protobuf::RepeatedField<double>* out) {
  out->Assign(numbers.begin(), numbers.end());
}

}  // namespace

std::uint64_t tangent_workspace(const Session& session,
                                const v1::LyapunovSpectrumRequest& request) {
  return session.simulation_bytes() +
         lyapunov_bytes(session.scene(), {.count = request.count()}, state_size(session));
}

LyapunovAnswer::~LyapunovAnswer() {
  if (simulation_) session_->release(std::move(simulation_));
}

LyapunovAnswer::LyapunovAnswer(SessionRef session, const v1::LyapunovSpectrumRequest& request)
    : session_(std::move(session)),
      request_(request),
      what_{.from = request.from(),
            .to = request.to(),
            .count = request.count(),
            .interval = request.interval(),
            .seed = request.seed()},
      start_(what_.from) {
  if (const std::string& bytes = request.checkpoint(); !bytes.empty()) {
    const auto content = verify_checkpoint(*session_, growth_format, bytes);
    if (!content)
      throw errors::checkpoint_refused(content.error(), bytes.size(), "LyapunovSpectrum");
    saved_ = *content;
    start_ = LyapunovExponents::saved_step(saved_);
    if (start_ < what_.from || start_ > what_.to)
      throw errors::invalid("checkpoint", "step " + std::to_string(start_),
                            "must be of a step between `from` and `to`");
  }
  simulation_ = session_->acquire(start_);
}

void LyapunovAnswer::begin() {
  const Scene& scene = session_->scene();
  spectrum_ = value_of(saved_.empty()
                           ? LyapunovExponents::make(scene, what_, *simulation_)
                           : LyapunovExponents::resume(scene, what_, saved_, *simulation_));
  const std::int64_t every = request_.every();
  mark_ = every > 0 ? what_.from + ((start_ - what_.from) / every + 1) * every : what_.to;
  covered_ = spectrum_->covered_steps();
}

bool LyapunovAnswer::checkpoint_is_due() const {
  constexpr std::int64_t most = 64, motions = 1 + LyapunovExponents::most_second_motions;
  return spectrum_->covered_steps() - covered_ > motions * (what_.to - what_.from) / most;
}

void LyapunovAnswer::take_checkpoint() {
  const std::string content = spectrum_->save();
  checkpoint_ = seal_checkpoint(*session_, growth_format, {content});
  checkpoint_step_ = LyapunovExponents::saved_step(content);
  covered_ = spectrum_->covered_steps();
}

bool LyapunovAnswer::save(bool interrupted) {
  if (interrupted) return false;
  const std::int64_t before = checkpoint_step_;
  if (spectrum_ && !has_results()) {
    take_checkpoint();
    if (checkpoint_step_ == before) checkpoint_.clear();
  }
  return has_results();
}

void LyapunovAnswer::advance(std::int64_t steps, const std::stop_token& stop) {
  if (!spectrum_) {
    if (simulation_->step() == start_) return begin();
    const std::int64_t left = start_ - simulation_->step(), before = simulation_->step();
    status_ = simulation_->advance(session_->direct() ? left : std::min(steps, left), stop);
    computed_ += session_->direct() ? 1 : simulation_->step() - before;
    ended_ = !status_.reached();
  } else if (!spectrum_->done()) {
    // The end of the interval in which the mark is.
    const std::int64_t interval = spectrum_->interval();
    const std::int64_t end = what_.from + ((mark_ - what_.from - 1) / interval + 1) * interval;
    const bool before = simulation_->step() < std::min(end, what_.to);
    status_ = spectrum_->advance(*simulation_,
                                 before ? std::min(steps, end - simulation_->step()) : steps, stop);
    ended_ = !status_.reached();
    if (before && spectrum_->step() == end && end < what_.to) {
      due_ = true;
      mark_ += ((end - mark_) / request_.every() + 1) * request_.every();
    }
  }
  if (status_.outcome == Outcome::cancelled) throw Stopped();
  if (spectrum_ && spectrum_->done()) ended_ = true;
  if (spectrum_ && (ended_ || checkpoint_is_due())) take_checkpoint();
}

bool LyapunovAnswer::next(v1::LyapunovSpectrumResponse& message) {
  message.Clear();
  const bool due = std::exchange(due_, false);
  const std::int64_t step = spectrum_ ? spectrum_->step() : simulation_->step();
  message.set_step(step);
  message.set_time(session_->scene().time(step));
  message.set_computed_steps(computed_steps());
  if (spectrum_) message.set_interval(spectrum_->interval());
  if (!checkpoint_.empty()) {
    message.mutable_checkpoint()->set_step(checkpoint_step_);
    message.mutable_checkpoint()->set_data(std::exchange(checkpoint_, {}));
  }
  const bool last = ended_;
  const bool has_numbers = spectrum_ && spectrum_->step() > what_.from;
  if (has_numbers && (last || due)) {
    put(spectrum_->exponents(), message.mutable_exponents());
    put(spectrum_->log_gali(), message.mutable_log_gali());
  }
  if (!last) return false;
  if (has_numbers) {
    const Eigen::VectorXd errors = spectrum_->errors();
    if (errors.allFinite()) put(errors, message.mutable_errors());
  }
  message.set_verdict(
      same_order(spectrum_ ? spectrum_->kind() : MotionKind::undecided, v1::VERDICT_UNDECIDED));
  message.set_reason(spectrum_ ? spectrum_->reason()
                               : "The motion ended before the vectors started.");
  to_proto(status_, message.mutable_run_status());
  return true;
}

}  // namespace stiefel::server
