#include "server/convert/tangents/lyapunov_answer.h"

#include <algorithm>
#include <string>
#include <utility>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

void put(const Eigen::VectorXd& numbers, google::protobuf::RepeatedField<double>* out) {
  out->Assign(numbers.begin(), numbers.end());
}

v1::Verdict verdict_of(MotionKind kind) {
  switch (kind) {
    case MotionKind::regular:
      return v1::VERDICT_REGULAR;
    case MotionKind::chaotic:
      return v1::VERDICT_CHAOTIC;
    case MotionKind::undecided:
      break;
  }
  return v1::VERDICT_UNDECIDED;
}

}  // namespace

TangentPrice price_of(const Session& session, const v1::LyapunovSpectrumRequest& request) {
  const std::int64_t size = state_size(session);
  const LyapunovDescription what{.count = request.count()};
  const auto vectors = std::min(lyapunov_vectors(what, size), size);
  const double step = session.most_work(0, 1);
  const auto steps = static_cast<double>(request.to() - request.from());
  TangentPrice price;
  price.of_step = lyapunov_work(session.scene(), step, vectors, size);
  const std::int64_t start = session.start_for(request.from());
  price.total = session.most_work(start, request.to()) +
                steps * (price.of_step + confirmation_work(session.scene(), step, size));
  price.bytes = session.simulation_bytes() + lyapunov_bytes(session.scene(), what, size);
  return price;
}

LyapunovAnswer::~LyapunovAnswer() {
  if (simulation_) session_->give_back(std::move(simulation_));
}

grpc::Status LyapunovAnswer::read() {
  what_ = {.from = request_.from(),
           .to = request_.to(),
           .count = request_.count(),
           .interval = request_.interval(),
           .seed = request_.seed()};
  start_ = what_.from;
  if (request_.checkpoint().empty()) return grpc::Status::OK;
  const auto content = verify_checkpoint(*session_, growth_format, request_.checkpoint());
  if (content) {
    saved_ = *content;
    start_ = LyapunovExponents::saved_step(saved_);
    if (start_ >= what_.from && start_ <= what_.to) return grpc::Status::OK;
    return errors::invalid("checkpoint", "step " + std::to_string(start_),
                           "must be of a step between `from` and `to`");
  }
  if (content.error().fault == CheckpointFault::other_numerics)
    return errors::checkpoint_of_other_numerics(content.error().numerics_id, numerics_id());
  return errors::invalid("checkpoint", std::to_string(request_.checkpoint().size()) + " bytes",
                         content.error().fault == CheckpointFault::other_scene
                             ? "must come from a session of the same scene"
                             : "is damaged: must be the bytes that LyapunovSpectrum returned");
}

grpc::Status LyapunovAnswer::make() {
  if (auto status = read(); !status.ok()) return status;
  simulation_ = session_->lease(start_);
  return grpc::Status::OK;
}

grpc::Status LyapunovAnswer::begin() {
  auto made = saved_.empty()
                  ? LyapunovExponents::make(session_->scene(), what_, *simulation_)
                  : LyapunovExponents::resume(session_->scene(), what_, saved_, *simulation_);
  if (!made) return errors::invalid(made.error());
  spectrum_.emplace(*std::move(made));
  const std::int64_t every = request_.every();
  mark_ = every > 0 ? what_.from + ((start_ - what_.from) / every + 1) * every : what_.to;
  covered_ = spectrum_->covered_steps();
  return grpc::Status::OK;
}

std::int64_t LyapunovAnswer::steps_between_checkpoints() const {
  constexpr double most = 64;
  constexpr double least_work = 1e10;
  if (work_ < least_work) return std::numeric_limits<std::int64_t>::max();
  const double part = std::max(1. / most, least_work / work_);
  constexpr double motions = 1 + LyapunovExponents::most_second_motions;
  return static_cast<std::int64_t>(part * motions * static_cast<double>(what_.to - what_.from)) + 1;
}

void LyapunovAnswer::take_checkpoint() {
  const std::string content = spectrum_->save();
  checkpoint_ = seal_checkpoint(*session_, growth_format, {content});
  checkpoint_step_ = LyapunovExponents::saved_step(content);
  covered_ = spectrum_->covered_steps();
  sent_ = 0;
}

bool LyapunovAnswer::save() {
  const std::int64_t before = checkpoint_step_;
  if (spectrum_ && !has_results()) {
    take_checkpoint();
    if (checkpoint_step_ == before) sent_ = checkpoint_.size();
  }
  return has_results();
}

grpc::Status LyapunovAnswer::advance(std::int64_t steps, const std::stop_token& stop) {
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
  if (status_.outcome == Outcome::cancelled) return errors::cancelled();
  if (spectrum_ && spectrum_->done()) ended_ = true;
  if (spectrum_ && (ended_ || spectrum_->covered_steps() - covered_ >= steps_between_checkpoints()))
    take_checkpoint();
  return grpc::Status::OK;
}

bool LyapunovAnswer::next(v1::LyapunovSpectrumResponse& message) {
  message.Clear();
  const bool due = std::exchange(due_, false);
  const std::int64_t step = spectrum_ ? spectrum_->step() : simulation_->step();
  message.set_step(step);
  message.set_time(session_->scene().time(step));
  message.set_computed_steps(computed_steps());
  if (!std::exchange(priced_, true)) {
    to_proto(work_, checkpoint_.size(), v1::PRICE_BOUND_AT_MOST,
             session_->simulation_bytes() + memory_, message.mutable_price());
  }
  if (spectrum_) message.set_interval(spectrum_->interval());
  if (sent_ < checkpoint_.size()) {
    auto& part = *message.mutable_checkpoint();
    part.set_step(checkpoint_step_);
    part.set_size(checkpoint_.size());
    part.set_offset(sent_);
    part.set_data(checkpoint_.substr(sent_, part_bytes));
    sent_ += part.data().size();
  }
  const bool last = ended_ && sent_ == checkpoint_.size();
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
  message.set_verdict(spectrum_ ? verdict_of(spectrum_->kind()) : v1::VERDICT_UNDECIDED);
  message.set_reason(spectrum_ ? spectrum_->reason()
                               : "The motion ended before the vectors started.");
  to_proto(status_, message.mutable_run_status());
  return true;
}

}  // namespace stiefel::server
