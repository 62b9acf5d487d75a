#include "server/sessions/sampling.h"

#include <algorithm>
#include <utility>

#include "server/scheduling/slice.h"

namespace stiefel::server {
namespace {

/// Returns the bytes of a sample with its step and time.
std::size_t whole_bytes(const Session& session, const std::vector<std::size_t>& fields) {
  return 2 * sizeof(double) + sample_bytes(session, fields);
}

}  // namespace

Sampling::Sampling(Session& session, std::vector<std::size_t> fields, Range range)
    : session_(session),
      fields_(std::move(fields)),
      range_(range),
      cursor_(session, range.from),
      capacity_(std::max<std::size_t>(1, batch_bytes / whole_bytes(session, fields_))),
      next_(range.from),
      last_checkpoint_(range.from) {
  if (range.checkpoint_every > 0 && range.from - cursor_.start() > range.checkpoint_every)
    last_checkpoint_ = cursor_.start();
  const auto samples = (range.to - range.from) / range.every + 2;
  capacity_ = std::min(capacity_, static_cast<std::size_t>(samples));
}

void Sampling::fill(const std::stop_token& stop) {
  std::int64_t budget = slice_steps(session_.step_cost());
  while (!done_ && !full() && cursor_.advance(target(), budget, stop)) {
    if (cursor_.stopped()) return;
    if (cursor_.run_status().reached() && cursor_.step() < next_) {
      checkpoint();
      continue;
    }
    sample();
    if (!cursor_.run_status().reached() || next_ == range_.to) return end();
    if (range_.checkpoint_every > 0 && last_ - last_checkpoint_ >= range_.checkpoint_every)
      checkpoint();
    next_ = range_.to - next_ > range_.every ? next_ + range_.every : range_.to;
  }
}

std::int64_t Sampling::target() const {
  const std::int64_t every = range_.checkpoint_every;
  const std::int64_t before = last_ < 0 ? cursor_.start() : last_;
  if (every == 0 || next_ - before <= every || session_.direct()) return next_;
  return std::min(next_, last_checkpoint_ + every);
}

bool Sampling::save() {
  cursor_.cancel();
  const std::int64_t step = cursor_.step();
  if (range_.checkpoints() && step > cursor_.start() && step != last_checkpoint_) checkpoint();
  return !empty() || !batch_.checkpoint.bytes.empty();
}

Batch Sampling::take() {
  for (std::size_t i = 0; i < batch_.fields.size(); ++i)
    batch_.fields[i].resize(batch_.size() * field_bytes(session_, fields_[i]));
  return std::exchange(batch_, {});
}

void Sampling::sample() {
  const Simulation& simulation = cursor_.simulation();
  if (simulation.step() == last_) return;
  last_ = simulation.step();
  const std::size_t index = batch_.size();
  batch_.steps.push_back(last_);
  batch_.times.push_back(session_.scene().time(last_));
  batch_.fields.resize(fields_.size());
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const std::size_t size = field_bytes(session_, fields_[i]);
    std::string& bytes = batch_.fields[i];
    const std::size_t samples = std::max(capacity_, index + 1);
    if (bytes.size() < samples * size) bytes.resize(samples * size);
    write_field(session_, simulation, fields_[i], bytes.data() + index * size);
  }
}

}  // namespace stiefel::server
