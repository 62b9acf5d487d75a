#include "server/convert/parts.h"

#include <algorithm>

#include "server/convert/convert.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/scene_fields.h"

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

class Collector {
 public:
  template <Description T>
  void collect(const std::string& within, const T& description) {
    for_each_field<T>([&](const auto& field) {
      collect_field(within + std::string(field.name), description.*field.member);
    });
  }
  std::vector<SceneArray> take() { return std::move(arrays_); }

 private:
  template <class T>
  void collect_field(const std::string&, const T&) {}
  void collect_field(const std::string& path, const std::vector<double>& list) {
    if (!list.empty())
      arrays_.push_back({path, 1, static_cast<Eigen::Index>(list.size()), list.data(), nullptr});
  }
  void collect_field(const std::string& path, const std::map<std::string, Block>& blocks) {
    for (const auto& [name, block] : blocks)
      arrays_.push_back({path + "." + name, block.values.rows(), block.values.cols(),
                         block.values.data(),
                         block.imaginary.size() > 0 ? block.imaginary.data() : nullptr});
  }
  void collect_field(const std::string& path, const std::optional<BodyDescription>& body) {
    if (body) collect(path + ".", *body);
  }

  std::vector<SceneArray> arrays_;
};

}  // namespace

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

std::vector<SceneArray> arrays_of(const SceneDescription& description) {
  Collector collector;
  collector.collect("", description);
  return collector.take();
}

v1::Field to_field(const SceneArray& array) {
  v1::Field out;
  out.set_name(array.path);
  v1::Tensor& tensor = *out.mutable_value();
  tensor.add_shape(static_cast<std::uint64_t>(array.rows));
  tensor.add_shape(static_cast<std::uint64_t>(array.cols));
  tensor.mutable_data()->resize(array.bytes());
  auto* numbers = reinterpret_cast<double*>(tensor.mutable_data()->data());
  const Eigen::Index size = array.rows * array.cols;
  if (array.imaginary == nullptr) {
    tensor.set_data_type(v1::DATA_TYPE_FLOAT64);
    std::copy_n(array.values, size, numbers);
    return out;
  }
  tensor.set_data_type(v1::DATA_TYPE_COMPLEX128);
  for (Eigen::Index i = 0; i < size; ++i) {
    numbers[2 * i] = array.values[i];
    numbers[2 * i + 1] = array.imaginary[i];
  }
  return out;
}

std::vector<std::string> write_view(const SceneDescription& resolved, const Difference& difference,
                                    v1::SceneView view, v1::Scene* out) {
  if (view == v1::SCENE_VIEW_NONE) return {};
  const auto shown = [&](std::string_view path) {
    return view == v1::SCENE_VIEW_FULL || difference.fills_in(path);
  };
  std::vector<SceneArray> arrays = arrays_of(resolved);
  std::erase_if(arrays, [&](const SceneArray& array) { return !shown(array.path); });
  std::ranges::stable_sort(arrays, std::greater(), &SceneArray::bytes);
  std::size_t bytes = 0;
  for (const SceneArray& array : arrays) bytes += array.bytes();
  std::vector<std::string> left_out;
  for (const SceneArray& array : arrays) {
    if (bytes <= max_reply_bytes) break;
    bytes -= array.bytes();
    left_out.push_back(array.path);
  }
  to_proto(
      resolved,
      [&](std::string_view path) {
        return shown(path) && std::ranges::find(left_out, path) == left_out.end();
      },
      out);
  return left_out;
}

}  // namespace stiefel::server
