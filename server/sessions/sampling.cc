#include "server/sessions/sampling.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "server/sessions/pool.h"

namespace stiefel::server {
namespace {

static_assert(std::endian::native == std::endian::little);

std::size_t sample_bytes(const Session& session, const std::vector<std::size_t>& fields) {
  std::size_t bytes = 2 * sizeof(double);  // step and time
  for (const std::size_t field : fields) {
    bytes += sizeof(double) * static_cast<std::size_t>(session.fields()[field].size());
  }
  return bytes;
}

}  // namespace

Sampling::Sampling(Session& session, std::vector<std::size_t> fields, Range range)
    : session_(session),
      fields_(std::move(fields)),
      range_(range),
      cursor_(session, range.from),
      capacity_(std::max<std::size_t>(1, batch_bytes / sample_bytes(session, fields_))),
      next_(range.from) {
  const auto samples = (range.to - range.from) / range.every + 2;
  capacity_ = std::min(capacity_, static_cast<std::size_t>(samples));
}

void Sampling::fill(Batch& batch, const std::stop_token& stop) {
  std::int64_t budget = slice_steps(session_.step_cost());
  while (!done_ && !full(batch) && cursor_.advance(next_, budget, stop)) {
    if (!cursor_.run_status().reached()) {
      done_ = true;
      return sample(batch);
    }
    sample(batch);
    done_ = next_ == range_.to;
    next_ = range_.to - next_ > range_.every ? next_ + range_.every : range_.to;
  }
}

void Sampling::cancel(Batch& batch) {
  if (done_) return;
  cursor_.cancel();
  done_ = true;
  sample(batch);
}

void Sampling::sample(Batch& batch) {
  const Simulation& simulation = cursor_.simulation();
  if (simulation.step() == last_) return;
  last_ = simulation.step();
  const std::size_t index = batch.size();
  batch.steps.push_back(last_);
  batch.times.push_back(session_.scene().time(last_));
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const auto size = static_cast<std::size_t>(session_.fields()[fields_[i]].size());
    std::string& bytes = batch.fields[i];
    const std::size_t samples = std::max(capacity_, index + 1);
    if (bytes.size() < samples * size * sizeof(double))
      bytes.resize(samples * size * sizeof(double));
    simulation.write(fields_[i], {reinterpret_cast<double*>(bytes.data()) + index * size, size});
  }
}

void Sampling::clear(Batch& batch) const {
  batch.steps.clear();
  batch.times.clear();
  batch.fields.resize(fields_.size());
}

void Sampling::trim(Batch& batch) const {
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const auto size = static_cast<std::size_t>(session_.fields()[fields_[i]].size());
    batch.fields[i].resize(batch.size() * size * sizeof(double));
  }
}

}  // namespace stiefel::server
