#pragma once

#include <Eigen/Core>
#include <bit>
#include <complex>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "stiefel/client/call.h"

namespace stiefel::client {

static_assert(std::endian::native == std::endian::little, "tensors are little-endian on the wire");

/// A view of a matrix in a message, row by row. Scalar: double, std::complex<double>, float or
/// std::int64_t.
template <class Scalar = double>
using MatrixView =
    Eigen::Map<const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

/// Returns a view of a matrix of a tensor, without a copy. The last two axes of the tensor are the
/// matrix's rows and columns; `index` counts through all axes before them. A tensor of one axis is
/// one row. Throws std::invalid_argument if the tensor's numbers are no Scalar, std::out_of_range
/// if it has no matrix with this index, and Error if its bytes are not those of its shape.
template <class Scalar = double>
MatrixView<Scalar> matrix(const v1::Tensor& tensor, std::size_t index = 0);

/// A view of one sample: a step, its time, and the fields asked for. Valid as long as its message.
class Sample {
 public:
  using Fields = google::protobuf::RepeatedPtrField<v1::Field>;

  /// The sample of a reply of Step or Drive.
  explicit Sample(const v1::Sample& sample)
      : step_(sample.step()), time_(sample.time()), fields_(&sample.fields()) {}
  /// The sample `index` of a message of Stream.
  Sample(const v1::StreamResponse& batch, int index)
      : step_(batch.steps(index)),
        time_(batch.times(index)),
        fields_(&batch.fields()),
        index_(static_cast<std::size_t>(index)),
        samples_(static_cast<std::size_t>(batch.steps_size())) {}

  std::int64_t step() const { return step_; }
  double time() const { return time_; }
  std::vector<std::string_view> fields() const;
  /// Returns a field, rows × cols, of a scene of float as MatrixView<float>. In an ensemble, that
  /// of one member. Throws std::out_of_range if the sample has no such field or member,
  /// std::invalid_argument if its numbers are no Scalar.
  template <class Scalar = double>
  MatrixView<Scalar> field(std::string_view name, std::size_t member = 0) const {
    const v1::Tensor& tensor = find(name);
    return matrix<Scalar>(tensor, first(tensor, member) + member);
  }

 private:
  const v1::Tensor& find(std::string_view name) const;
  /// Returns the index of the first member's matrix. Throws std::out_of_range if there is no such
  /// member.
  std::size_t first(const v1::Tensor& tensor, std::size_t member) const;

  std::int64_t step_;
  double time_;
  const Fields* fields_;
  std::size_t index_ = 0;
  std::size_t samples_ = 1;  // in the tensors
};

/// The samples of a Stream, as an input range:
///
///     for (const Sample& sample : samples) use(sample.time(), sample.field("Q"));
///
/// or batch by batch with `next_batch`. Destruction cancels the call. Not thread-safe, but any
/// thread may cancel it.
class Samples {
 public:
  explicit Samples(Replies<v1::StreamResponse> replies) : replies_(std::move(replies)) {}

  /// Returns the next samples, as many as came in a message, null at the end. The batch is valid
  /// until the next call. Throws Error, also when the call breaks; a stream from the step after the
  /// last sample goes on.
  const v1::StreamResponse* next_batch();
  /// How the run ended; empty before the end.
  const std::optional<v1::RunStatus>& run_status() const { return run_status_; }
  /// The last checkpoint that came, if the request asks for them.
  const std::optional<v1::Checkpoint>& checkpoint() const { return checkpoint_; }
  /// The next batch then throws Error with the code CANCELLED.
  void cancel() { replies_.cancel(); }

  class Iterator {
   public:
    using iterator_concept = std::input_iterator_tag;
    using value_type = Sample;
    using difference_type = std::ptrdiff_t;

    explicit Iterator(Samples& samples) : samples_(&samples) { ++*this; }
    const Sample& operator*() const { return *sample_; }
    const Sample* operator->() const { return &*sample_; }
    Iterator& operator++() {
      if (!batch_ || ++index_ == batch_->steps_size()) {
        batch_ = samples_->next_batch();
        index_ = 0;
      }
      if (batch_) sample_.emplace(*batch_, index_);
      return *this;
    }
    void operator++(int) { ++*this; }
    bool operator==(std::default_sentinel_t) const { return batch_ == nullptr; }

   private:
    Samples* samples_;
    const v1::StreamResponse* batch_ = nullptr;
    int index_ = 0;
    std::optional<Sample> sample_;
  };

  /// May be called only once, because the samples are an input range.
  Iterator begin() { return Iterator(*this); }
  std::default_sentinel_t end() const { return {}; }

 private:
  Replies<v1::StreamResponse> replies_;
  std::optional<v1::Checkpoint> checkpoint_;
  std::optional<v1::RunStatus> run_status_;
};

}  // namespace stiefel::client
