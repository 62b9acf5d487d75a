#include "server/convert/parts.h"

#include <algorithm>

namespace stiefel::server {
namespace {

std::size_t number_bytes(v1::DataType type) {
  switch (type) {
    case v1::DATA_TYPE_COMPLEX128:
      return 2 * sizeof(double);
    case v1::DATA_TYPE_FLOAT32:
      return sizeof(float);
    default:
      return sizeof(double);
  }
}

/// Returns the bytes of the next part, at most `budget` unless one element is larger.
std::size_t part_of(const v1::Tensor& tensor, std::size_t begin, std::size_t budget) {
  const std::size_t left = tensor.data().size() - begin;
  if (left <= budget) return left;
  const std::size_t number = number_bytes(tensor.data_type());
  const std::size_t row = number * tensor.shape(tensor.shape_size() - 1);
  const std::size_t end = (begin + budget) / row * row;
  if (end > begin) return end - begin;
  return std::max(budget / number, std::size_t{1}) * number;
}

}  // namespace

std::size_t Parts::bytes() const {
  std::size_t sum = 0;
  for (const auto& field : fields_) sum += field.value().data().size();
  return sum - sent_;
}

void Parts::take(std::size_t budget, Fields* out) {
  while (!fields_.empty() && (budget > 0 || out->empty())) {
    v1::Field& field = fields_.front();
    const v1::Tensor& whole = field.value();
    const std::size_t size = whole.data().size();
    if (sent_ == 0 && size <= budget) {
      budget -= size;
      out->Add(std::move(field));
      fields_.pop_front();
      continue;
    }
    // The array would be split here but may fit whole into the next message.
    if (sent_ == 0 && !out->empty()) return;
    const std::size_t bytes = part_of(whole, sent_, budget);
    const std::size_t number = number_bytes(whole.data_type());
    v1::Field* part = out->Add();
    part->set_name(field.name());
    part->mutable_value()->set_data_type(whole.data_type());
    part->mutable_value()->add_shape(bytes / number);
    part->mutable_value()->set_data(whole.data().data() + sent_, bytes);
    *part->mutable_whole_shape() = whole.shape();
    part->set_offset(sent_ / number);
    budget -= std::min(budget, bytes);
    sent_ += bytes;
    if (sent_ < size) return;
    sent_ = 0;
    fields_.pop_front();
  }
}

}  // namespace stiefel::server
