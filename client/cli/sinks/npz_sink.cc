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

void check(int result) {
  if (result != ZIP_OK) throw std::runtime_error("cannot write the archive");
}

void open_entry(zipFile archive, const std::string& name) {
  zip_fileinfo no_date = {};
  no_date.dosDate = (1u << 21) | (1u << 16);  // 1980-01-01, so that equal runs give equal files
  check(zipOpenNewFileInZip64(archive, (name + ".npy").c_str(), &no_date, nullptr, 0, nullptr, 0,
                              nullptr, 0, 0, 1));
}

void write_entry(zipFile archive, std::string_view bytes) {
  check(zipWriteInFileInZip(archive, bytes.data(), static_cast<unsigned>(bytes.size())));
}

/// Returns the header of the .npy format, version 1.0: magic, version, length, and a Python dict,
/// padded to a multiple of 64 bytes. `shape`: "3, 4," or nothing for a single value.
std::string npy_header(const std::string& type, const std::string& shape) {
  std::string dict =
      "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
  dict.append(63 - (10 + dict.size()) % 64, ' ').append("\n");
  std::string text("\x93NUMPY\x01\x00", 8);
  text += static_cast<char>(dict.size() & 0xff);
  text += static_cast<char>(dict.size() >> 8);
  return text + dict;
}

/// Writes an array that holds one text.
void write_text(zipFile archive, const std::string& name, const std::string& text) {
  open_entry(archive, name);
  write_entry(archive, npy_header("|S" + std::to_string(text.size()), ""));
  write_entry(archive, text);
  check(zipCloseFileInZip(archive));
}

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
    std::string shape = std::to_string(samples) + ",";
    for (const auto extent : shape_) shape.append(" ").append(std::to_string(extent)).append(",");
    open_entry(archive, name_);
    write_entry(archive, npy_header(type_, shape));
    std::rewind(file_.get());
    char block[1 << 16];
    while (const std::size_t size = std::fread(block, 1, sizeof block, file_.get())) {
      write_entry(archive, {block, size});
    }
    if (std::ferror(file_.get())) throw std::runtime_error("cannot read the samples back");
    check(zipCloseFileInZip(archive));
  }

 private:
  std::string name_;
  std::string type_;
  std::vector<std::uint64_t> shape_;
  File file_;
};

template <class Number>
std::string_view bytes(const google::protobuf::RepeatedField<Number>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

/// Writes an archive for numpy.load: the arrays `step`, `time`, one for every field, for a matrix
/// (samples, rows, cols), for a vector (samples, n), and `stiefel`, the description as JSON.
class NpzSink : public Sink {
 public:
  explicit NpzSink(const std::string& path)
      : destination_(path),
        step_("step", "<i8", {}, destination_.working_path()),
        time_("time", "<f8", {}, destination_.working_path()) {
    open_for_writing(destination_.working_path());
  }

  void write(const v1::StreamResponse& batch) override {
    description_.take(batch);
    if (fields_.empty()) {
      for (const auto& field : batch.fields()) {
        fields_.emplace_back(field.name(), numpy_type(field.value().data_type()),
                             sample_shape(field), destination_.working_path());
      }
    }
    samples_ += static_cast<std::uint64_t>(batch.steps_size());
    step_.append(bytes(batch.steps()));
    time_.append(bytes(batch.times()));
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      fields_[i].append(batch.fields(static_cast<int>(i)).value().data());
    }
  }

  void finish(const nlohmann::ordered_json&, const nlohmann::ordered_json& ending) override {
    const zipFile archive = zipOpen64(destination_.working_path().c_str(), APPEND_STATUS_CREATE);
    if (!archive) throw std::runtime_error("cannot write " + destination_.working_path());
    step_.copy_to(archive, samples_);
    time_.copy_to(archive, samples_);
    for (auto& field : fields_) field.copy_to(archive, samples_);
    nlohmann::ordered_json description = description_.json();
    description.update(ending);
    write_text(archive, "stiefel", description.dump());
    check(zipClose(archive, nullptr));
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
