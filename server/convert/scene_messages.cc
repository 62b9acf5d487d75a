#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/reflection.h>

#include <algorithm>
#include <complex>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/sessions/scene_fields.h"

namespace stiefel::server {
namespace {

/// The value and the rule of a fault.
using Text = std::pair<std::string, std::string>;

void read_values(const Path& path, const v1::Matrix& matrix,
                 const google::protobuf::RepeatedField<double>& values, RowMatrix& out,
                 Faults& faults) {
  const std::uint64_t size = std::uint64_t{matrix.rows()} * matrix.cols();
  if (static_cast<std::uint64_t>(values.size()) != size) {
    return faults.add(path, [&] {
      return Text(std::to_string(values.size()) + " values",
                  "must be rows * cols = " + std::to_string(size));
    });
  }
  out = Eigen::Map<const RowMatrix>(values.data(), matrix.rows(), matrix.cols());
}

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

const FieldDescriptor* field_of(const Message& message, std::string_view name) {
  const auto* found = message.GetDescriptor()->FindFieldByName(std::string(name));
  if (found == nullptr)
    throw std::logic_error(message.GetTypeName() + " has no field " + std::string(name));
  return found;
}

/// Reads a description's fields by name, with one overload for each type of field.
class Reader {
 public:
  explicit Reader(Faults& faults) : faults_(faults) {}

  /// `within` is the path of `from` in the description: "" or "method".
  template <Description T>
  void read(const Message& from, const Path& within, T& out) {
    for_each_field<T>([&](const auto& field) {
      read(from, field_of(from, field.name), Path(within, field.name), out.*field.member);
    });
  }

 private:
  using Field = const FieldDescriptor*;

  void read(const Message& from, Field field, const Path&, std::string& out) {
    out = from.GetReflection()->GetString(from, field);
  }
  void read(const Message& from, Field field, const Path&, std::optional<double>& out) {
    const auto& reflection = *from.GetReflection();
    if (reflection.HasField(from, field)) out = reflection.GetDouble(from, field);
  }
  void read(const Message& from, Field field, const Path&, std::vector<double>& out) {
    const auto numbers = from.GetReflection()->GetRepeatedFieldRef<double>(from, field);
    out.assign(numbers.begin(), numbers.end());
  }
  void read(const Message& from, Field field, const Path& path, std::optional<int>& out) {
    const auto& reflection = *from.GetReflection();
    if (!reflection.HasField(from, field)) return;
    const std::uint32_t value = reflection.GetUInt32(from, field);
    if (value > static_cast<std::uint32_t>(std::numeric_limits<int>::max()))
      faults_.add(path, std::to_string(value), "is too large");
    else
      out = static_cast<int>(value);
  }
  template <Description T>
  void read(const Message& from, Field field, const Path& path, std::optional<T>& out) {
    const auto& reflection = *from.GetReflection();
    if (reflection.HasField(from, field))
      read(reflection.GetMessage(from, field), path, out.emplace());
  }
  /// Reads the blocks of a scene; large ones are in the field `initial_tensors`.
  void read(const Message& from, Field, const Path& path, std::map<std::string, Block>& out) {
    const auto& scene = dynamic_cast<const v1::Scene&>(from);
    const auto given =
        static_cast<std::size_t>(scene.initial_size() + scene.initial_tensors_size());
    if (given > most_blocks)
      return faults_.add(path, std::to_string(given) + " blocks",
                         "must be at most " + std::to_string(most_blocks));
    for (const auto& [name, matrix] : scene.initial())
      read_block(Path(path, name), matrix, out[name], faults_);
    const Path tensors("initial_tensors");
    for (const auto& [name, tensor] : scene.initial_tensors())
      if (scene.initial().contains(name))
        faults_.add(Path(tensors, name), "given", "must be absent: it is in " + path.text());
      else
        read_block(Path(tensors, name), tensor, out[name], faults_);
  }

  /// More than any system has.
  static constexpr std::size_t most_blocks = 64;

  Faults& faults_;
};

/// Writes the set fields of a description, by name.
class FieldWriter {
 public:
  template <Description T>
  static void write(const T& description, Message* to) {
    for_each_field<T>([&](const auto& field) {
      write(description.*field.member, to, field_of(*to, field.name));
    });
  }

 private:
  using Field = const FieldDescriptor*;

  static void write(const std::string& value, Message* to, Field field) {
    to->GetReflection()->SetString(to, field, value);
  }
  static void write(const std::optional<double>& value, Message* to, Field field) {
    if (value) to->GetReflection()->SetDouble(to, field, *value);
  }
  static void write(const std::optional<int>& value, Message* to, Field field) {
    if (value) to->GetReflection()->SetUInt32(to, field, static_cast<std::uint32_t>(*value));
  }
  static void write(const std::vector<double>& values, Message* to, Field field) {
    const auto numbers = to->GetReflection()->GetMutableRepeatedFieldRef<double>(to, field);
    for (const double value : values) numbers.Add(value);
  }
  static void write(const std::map<std::string, Block>& blocks, Message* to, Field) {
    auto& initial = *dynamic_cast<v1::Scene&>(*to).mutable_initial();
    for (const auto& [name, block] : blocks) write_block(block, &initial[name]);
  }
  template <Description T>
  static void write(const std::optional<T>& value, Message* to, Field field) {
    if (value) write(*value, to->GetReflection()->MutableMessage(to, field));
  }
};

}  // namespace

void read_block(const Path& path, const v1::Matrix& matrix, Block& out, Faults& faults) {
  const auto check = [&](const char* name, std::uint32_t value) {
    if (value >= 1 && value <= Scene::max_elements) return true;
    faults.add(Path(path, name), [&] {
      return Text(std::to_string(value), "must be 1 to " + std::to_string(Scene::max_elements));
    });
    return false;
  };
  const bool rows = check("rows", matrix.rows());
  const bool cols = check("cols", matrix.cols());
  if (!rows || !cols) return;
  if (std::uint64_t{matrix.rows()} * matrix.cols() > Scene::max_elements)
    return faults.add(path, [&] {
      return Text(std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()),
                  "must have at most " + std::to_string(Scene::max_elements) + " elements");
    });
  read_values(Path(path, "values"), matrix, matrix.values(), out.values, faults);
  if (matrix.imaginary_size() > 0)
    read_values(Path(path, "imaginary"), matrix, matrix.imaginary(), out.imaginary, faults);
}

void read_block(const Path& path, const v1::Tensor& tensor, Block& out, Faults& faults) {
  const auto refuse = [&](const char* name, std::string value, std::string rule) {
    faults.add(Path(path, name), std::move(value), std::move(rule));
  };
  const bool complex = tensor.data_type() == v1::DATA_TYPE_COMPLEX128;
  if (!complex && tensor.data_type() != v1::DATA_TYPE_FLOAT64)
    return refuse("data_type", v1::DataType_Name(tensor.data_type()),
                  "must be DATA_TYPE_FLOAT64 or DATA_TYPE_COMPLEX128");
  std::string shape;
  std::uint64_t size = 1;
  for (int k = 0; k < std::min(tensor.shape_size(), 4); ++k) {
    const auto extent = tensor.shape(k);
    shape += (k == 0 ? "" : " x ") + std::to_string(extent);
    size = extent >= 1 && extent <= Scene::max_elements ? size * extent : 0;
    if (size > Scene::max_elements) size = 0;
  }
  if (size == 0 || tensor.shape_size() < 2 || tensor.shape_size() > 3)
    return refuse("shape", shape,
                  "must be (rows, cols) or (members, rows, cols), of 1 to " +
                      std::to_string(Scene::max_elements) + " elements");
  const std::uint64_t bytes = size * sizeof(double) * (complex ? 2 : 1);
  if (tensor.data().size() != bytes)
    return refuse("data", std::to_string(tensor.data().size()) + " bytes",
                  "must have " + std::to_string(bytes) + " for the shape " + shape);
  const auto cols = static_cast<Eigen::Index>(tensor.shape(tensor.shape_size() - 1));
  const auto rows = static_cast<Eigen::Index>(size) / cols;
  RowMatrix numbers(rows, complex ? 2 * cols : cols);
  std::memcpy(numbers.data(), tensor.data().data(), bytes);
  if (!complex) {
    out.values = std::move(numbers);
    return;
  }
  using Complex = std::complex<double>;
  const Eigen::Map<const Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>
      pairs(reinterpret_cast<const Complex*>(numbers.data()), rows, cols);
  out.values = pairs.real();
  out.imaginary = pairs.imag();
}

RowMatrix read_matrix(const Path& path, const v1::Matrix& matrix, Faults& faults) {
  Block out;
  read_block(path, matrix, out, faults);
  if (out.values.size() == 0) return {};
  if (matrix.imaginary_size() > 0)
    faults.add(Path(path, "imaginary"), std::to_string(matrix.imaginary_size()) + " values",
               "must be absent: the matrix is real");
  else if (out.values.allFinite())
    return std::move(out.values);
  else
    faults.add(path, "infinite or not a number", "must be finite");
  return {};
}

RowMatrix read_given(const Path& path, bool present, const v1::Matrix& matrix, Faults& faults) {
  if (present) return read_matrix(path, matrix, faults);
  faults.add(path, "absent", "must be given");
  return {};
}

void to_proto(const RowMatrix& values, v1::Matrix* out) {
  out->set_rows(static_cast<std::uint32_t>(values.rows()));
  out->set_cols(static_cast<std::uint32_t>(values.cols()));
  out->mutable_values()->Add(values.data(), values.data() + values.size());
}

void write_block(const Block& block, v1::Matrix* out) {
  to_proto(block.values, out);
  out->mutable_imaginary()->Add(block.imaginary.data(),
                                block.imaginary.data() + block.imaginary.size());
}

namespace {

template <Description T>
T read(const Message& message, const Place& place) {
  Faults faults(place);
  T out;
  Reader(faults).read(message, "", out);
  check(faults);
  return out;
}

}  // namespace

MethodDescription from_proto(const v1::Method& method, const Place& place) {
  return read<MethodDescription>(method, place);
}

SceneDescription from_proto(const v1::Scene& scene, const Place& place) {
  return read<SceneDescription>(scene, place);
}

void to_proto(const MethodDescription& method, v1::Method* out) { FieldWriter::write(method, out); }

void to_proto(const SceneDescription& description, v1::Scene* out) {
  FieldWriter::write(description, out);
}

}  // namespace stiefel::server
