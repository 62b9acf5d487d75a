#include <minizip/zip.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "client/cli/exit_status.h"
#include "client/cli/sinks/destination.h"
#include "client/cli/sinks/sink.h"

namespace stiefel::cli {
namespace {

/// Collects one array in an unnamed file until the archive is written. An archive holds its arrays
/// one after the other, while each sample brings a piece of every array.
class Spool {
 public:
  /// `shape`: the shape of one sample. `path`: a file in the folder that takes the unnamed file.
  Spool(std::string name, std::string type, std::vector<std::uint64_t> shape,
        const std::string& path)
      : name_(std::move(name)), type_(std::move(type)), shape_(std::move(shape)) {
    std::string pattern = path + ".XXXXXX";
    const int descriptor = mkstemp(pattern.data());
    if (descriptor >= 0) unlink(pattern.c_str());
    file_.reset(descriptor >= 0 ? fdopen(descriptor, "w+b") : nullptr);
    if (!file_) throw BadInput("--output: cannot write " + pattern + ": " + std::strerror(errno));
  }

  void append(std::string_view bytes) { write(file_.get(), bytes); }

  void copy_to(zipFile archive, std::uint64_t samples) {
    const std::string entry = name_ + ".npy";
    zip_fileinfo no_date = {};
    no_date.dosDate = (1u << 21) | (1u << 16);  // 1980-01-01, so that equal runs give equal files
    check(zipOpenNewFileInZip64(archive, entry.c_str(), &no_date, nullptr, 0, nullptr, 0, nullptr,
                                0, 0, 1));
    const std::string start = header(samples);
    check(zipWriteInFileInZip(archive, start.data(), static_cast<unsigned>(start.size())));
    std::rewind(file_.get());
    char block[1 << 16];
    while (const std::size_t size = std::fread(block, 1, sizeof block, file_.get())) {
      check(zipWriteInFileInZip(archive, block, static_cast<unsigned>(size)));
    }
    if (std::ferror(file_.get())) throw std::runtime_error("cannot read the samples back");
    check(zipCloseFileInZip(archive));
  }

  static void check(int result) {
    if (result != ZIP_OK) throw std::runtime_error("cannot write the archive");
  }

 private:
  /// Returns the header of the .npy format, version 1.0: magic, version, length, and a Python dict,
  /// padded to a multiple of 64 bytes.
  std::string header(std::uint64_t samples) const {
    std::string shape = std::to_string(samples) + ",";
    for (const auto extent : shape_) shape.append(" ").append(std::to_string(extent)).append(",");
    std::string dict =
        "{'descr': '" + type_ + "', 'fortran_order': False, 'shape': (" + shape + "), }";
    dict.append(63 - (10 + dict.size()) % 64, ' ').append("\n");
    std::string text("\x93NUMPY\x01\x00", 8);
    text += static_cast<char>(dict.size() & 0xff);
    text += static_cast<char>(dict.size() >> 8);
    return text + dict;
  }

  std::string name_;
  std::string type_;
  std::vector<std::uint64_t> shape_;
  File file_;
};

template <class Number>
std::string_view bytes(const google::protobuf::RepeatedField<Number>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

std::string numpy_type(v1::DataType type) {
  if (type == v1::DATA_TYPE_COMPLEX128) return "<c16";
  return type == v1::DATA_TYPE_FLOAT32 ? "<f4" : "<f8";
}

/// Writes an archive for numpy.load: the arrays `step`, `time`, and one for every field, for a
/// matrix (samples, rows, cols), for a vector (samples, n).
class NpzSink : public Sink {
 public:
  explicit NpzSink(const std::string& path)
      : destination_(path),
        step_("step", "<i8", {}, destination_.working_path()),
        time_("time", "<f8", {}, destination_.working_path()) {
    open_for_writing(destination_.working_path());
  }

  void write(const v1::StreamResponse& batch) override {
    if (fields_.empty()) {
      for (const auto& field : batch.fields()) {
        const auto& shape = field.value().shape();
        // The axes of length 1 of a vector or a number are those behind the samples and members.
        std::vector<std::uint64_t> sample(shape.begin() + 1, shape.end());
        const auto axes = static_cast<std::ptrdiff_t>(kind_of(field.name()).axes);
        if (axes < 2) sample.erase(sample.end() - 2, sample.end() - axes);
        fields_.emplace_back(field.name(), numpy_type(field.value().data_type()), sample,
                             destination_.working_path());
      }
    }
    samples_ += static_cast<std::uint64_t>(batch.steps_size());
    step_.append(bytes(batch.steps()));
    time_.append(bytes(batch.times()));
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      fields_[i].append(batch.fields(static_cast<int>(i)).value().data());
    }
  }

  void finish(const nlohmann::ordered_json&) override {
    const zipFile archive = zipOpen64(destination_.working_path().c_str(), APPEND_STATUS_CREATE);
    if (!archive) throw std::runtime_error("cannot write " + destination_.working_path());
    step_.copy_to(archive, samples_);
    time_.copy_to(archive, samples_);
    for (auto& field : fields_) field.copy_to(archive, samples_);
    Spool::check(zipClose(archive, nullptr));
    destination_.commit();
  }

 private:
  Destination destination_;
  Spool step_;
  Spool time_;
  std::vector<Spool> fields_;
  std::uint64_t samples_ = 0;
};

}  // namespace

std::unique_ptr<Sink> make_npz_sink(const std::string& path) {
  return std::make_unique<NpzSink>(path);
}

}  // namespace stiefel::cli
