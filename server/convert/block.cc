#include "server/convert/block.h"

#include <cstring>

#include "server/convert/convert.h"

namespace stiefel::server {
namespace {

void read_values(const std::string& path, const v1::Matrix& matrix,
                 const google::protobuf::RepeatedField<double>& values, RowMatrix& out,
                 Faults& faults) {
  const std::uint64_t size = std::uint64_t{matrix.rows()} * matrix.cols();
  if (static_cast<std::uint64_t>(values.size()) != size) {
    faults.add(path, std::to_string(values.size()) + " values",
               "must be rows * cols = " + std::to_string(size));
    return;
  }
  out = Eigen::Map<const RowMatrix>(values.data(), matrix.rows(), matrix.cols());
}

}  // namespace

void read_block(const std::string& path, const v1::Matrix& matrix, Block& out, Faults& faults) {
  const auto check = [&](const char* name, std::uint32_t value) {
    if (value >= 1 && value <= Scene::max_elements) return true;
    faults.add(path + "." + name, std::to_string(value),
               "must be 1 to " + std::to_string(Scene::max_elements));
    return false;
  };
  const bool rows = check("rows", matrix.rows());
  const bool cols = check("cols", matrix.cols());
  if (!rows || !cols) return;
  if (std::uint64_t{matrix.rows()} * matrix.cols() > Scene::max_elements) {
    faults.add(path, std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()),
               "must have at most " + std::to_string(Scene::max_elements) + " elements");
    return;
  }
  read_values(path + ".values", matrix, matrix.values(), out.values, faults);
  if (matrix.imaginary_size() > 0)
    read_values(path + ".imaginary", matrix, matrix.imaginary(), out.imaginary, faults);
}

void read_block(const std::string& path, const v1::Tensor& tensor, Block& out, Faults& faults) {
  const auto refuse = [&](const char* name, std::string value, std::string rule) {
    faults.add(path + "." + name, std::move(value), std::move(rule));
  };
  const bool complex = tensor.data_type() == v1::DATA_TYPE_COMPLEX128;
  if (!complex && tensor.data_type() != v1::DATA_TYPE_FLOAT64)
    return refuse("data_type", v1::DataType_Name(tensor.data_type()),
                  "must be DATA_TYPE_FLOAT64 or DATA_TYPE_COMPLEX128");
  std::string shape;
  std::uint64_t size = 1;
  for (const auto extent : tensor.shape()) {
    shape += (shape.empty() ? "" : " x ") + std::to_string(extent);
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

std::expected<Block, Violations> from_proto(const std::string& path, const v1::Matrix& matrix) {
  Block out;
  const Place here;
  Faults faults{here};
  read_block(path, matrix, out, faults);
  if (!out.values.allFinite() || !out.imaginary.allFinite())
    faults.add(path, "infinite or not a number", "must be finite");
  if (!faults.violations.empty()) return std::unexpected(std::move(faults.violations));
  return out;
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
