#include "server/convert/block.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "server/convert/convert.h"

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
  out.values = numbers(Eigen::all, Eigen::seqN(0, cols, 2));
  out.imaginary = numbers(Eigen::all, Eigen::seqN(1, cols, 2));
}

std::optional<Block> read_matrix(const Path& path, const v1::Matrix& matrix, Faults& faults) {
  Block out;
  read_block(path, matrix, out, faults);
  if (out.values.size() == 0) return std::nullopt;
  if (out.values.allFinite() && out.imaginary.allFinite()) return out;
  faults.add(path, "infinite or not a number", "must be finite");
  return std::nullopt;
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

}  // namespace stiefel::server
