#include "engine/growth/growth.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stiefel {
namespace {

constexpr std::size_t least_batches = 8;

/// Returns the 97.5 % point of Student's distribution with ν ≥ 7 degrees of freedom, to 4e-4, from
/// its expansion in 1/ν.
double student(double nu) {
  constexpr double z = 1.959963984540054, a = z * z;
  return z * (1 + (a + 1) / (4 * nu) + ((5 * a + 16) * a + 3) / (96 * nu * nu) +
              (((3 * a + 19) * a + 17) * a - 15) / (384 * nu * nu * nu));
}

}  // namespace

Growth::Growth(Eigen::Index k)
    : sums_(Numbers::Zero(k)),
      directions_(Dense::Identity(k, k)),
      lengths_(Numbers::Zero(k)),
      open_{0, Eigen::Vector3d::Zero(), Numbers::Zero(k)} {}

void Growth::add(double duration, const Dense& R) {
  const Numbers logs = R.diagonal().array().log();
  sums_ += logs;
  time_ += duration;
  directions_ = (R * directions_).eval();
  for (Eigen::Index j = 0; j < count(); ++j) {
    const double norm = directions_.col(j).norm();
    directions_.col(j) /= norm;
    lengths_(j) += std::log(norm);
  }
  highest_ = std::max(highest_, sums_(0));
  deepest_fall_ = std::max(deepest_fall_, highest_ - sums_(0));

  const Numbers gali = log_gali();
  open_.time += duration;
  open_.growth += logs;
  const bool volumes = gali.size() > 0;
  open_.levels += duration * Eigen::Vector3d(sums_(0), volumes ? gali(0) : 0,
                                             volumes ? gali(gali.size() - 1) : 0);
  if (++open_length_ == block_length_) close_block();
}

void Growth::close_block() {
  blocks_.push_back(open_);
  open_ = {0, Eigen::Vector3d::Zero(), Numbers::Zero(count())};
  open_length_ = 0;
  if (blocks_.size() < most_blocks) return;
  for (std::size_t i = 0; i < most_blocks / 2; ++i) {
    const Block &one = blocks_[2 * i], &two = blocks_[2 * i + 1];
    blocks_[i] = {one.time + two.time, one.levels + two.levels, one.growth + two.growth};
  }
  blocks_.resize(most_blocks / 2);
  block_length_ *= 2;
}

Growth::Numbers Growth::log_gali() const {
  if (count() < 2) return Numbers(0);
  Numbers out(count() - 1);
  double log = sums_(0) - lengths_(0);
  for (Eigen::Index j = 1; j < count(); ++j) out(j - 1) = log += sums_(j) - lengths_(j);
  return out;
}

Growth::Numbers Growth::squared_error(std::size_t blocks_a_batch) const {
  const std::size_t batches = blocks_.size() / blocks_a_batch;
  Numbers sum = Numbers::Zero(count()), squares = Numbers::Zero(count());
  for (std::size_t b = 0; b < batches; ++b) {
    double time = 0;
    Numbers growth = Numbers::Zero(count());
    for (std::size_t i = b * blocks_a_batch; i < (b + 1) * blocks_a_batch; ++i) {
      time += blocks_[i].time;
      growth += blocks_[i].growth;
    }
    growth /= time;
    sum += growth;
    squares += growth.cwiseAbs2();
  }
  const auto n = static_cast<double>(batches);
  const Numbers variance = ((squares - sum.cwiseAbs2() / n) / (n - 1)).cwiseMax(0);
  return variance * static_cast<double>(blocks_a_batch) / static_cast<double>(blocks_.size());
}

Growth::BatchMeans Growth::batch_means() const {
  if (blocks_.size() < 2 * least_batches)
    return {Numbers::Constant(count(), std::numeric_limits<double>::infinity())};
  BatchMeans out{Numbers::Zero(count())};
  const Numbers first = squared_error(1);
  Numbers before = first;
  for (std::size_t m = 1; blocks_.size() / m >= least_batches; m *= 2) {
    const Numbers now = squared_error(m);
    const auto batches = static_cast<double>(blocks_.size() / m);
    const double factor = student(batches - 1);
    out.errors = out.errors.cwiseMax(factor * now.cwiseSqrt());
    out.last_rise = now(0) / before(0);
    out.longest = time_ / batches;
    if (blocks_.size() / (2 * m) < least_batches)
      for (Eigen::Index i = 0; i < count(); ++i)
        if (first(i) > 0)
          out.errors(i) = std::max(out.errors(i), factor * now(i) / std::sqrt(first(i)));
    before = now;
  }
  return out;
}

Growth::Levels Growth::mean(int j) const {
  const std::size_t end = blocks_.size() >> j, begin = end / 2;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double time = 0;
  for (std::size_t i = begin; i < end; ++i) {
    time += blocks_[i].time;
    sum += blocks_[i].levels;
  }
  return {sum(0) / time, sum(1) / time, sum(2) / time};
}

template <class Self, class Visit>
void Growth::each(Self& self, const Visit& visit) {
  const auto all = [&](auto&& numbers) {
    for (auto&& x : numbers) visit(x);
  };
  const auto block = [&](auto& of) { visit(of.time), all(of.levels), all(of.growth); };
  visit(self.block_length_), visit(self.open_length_);
  visit(self.time_), visit(self.highest_), visit(self.deepest_fall_);
  all(self.sums_), all(self.lengths_), all(self.directions_.reshaped());
  block(self.open_);
  for (auto& of : self.blocks_) block(of);
}

void Growth::save(ByteWriter& out) const {
  out.put(static_cast<std::uint64_t>(blocks_.size()));
  each(*this, [&](const auto& number) { out.put(number); });
}

void Growth::restore(ByteReader& in) {
  std::uint64_t blocks = 0;
  in.get(blocks);
  blocks_.assign(std::min<std::uint64_t>(blocks, most_blocks), open_);
  each(*this, [&](auto& number) { in.get(number); });
  in.require(open_length_ < block_length_);
}

}  // namespace stiefel
