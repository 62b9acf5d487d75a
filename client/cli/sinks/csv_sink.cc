#include <algorithm>

#include "client/cli/sinks/destination.h"
#include "client/cli/sinks/sink.h"
#include "stiefel/client/samples.h"

namespace stiefel::cli {
namespace {

using client::SampleView;

void append_elements(std::string& text, const std::string& name, const client::FieldView& field) {
  for (std::size_t row = 1; row <= field.rows; ++row) {
    for (std::size_t col = 1; col <= field.cols; ++col) {
      const std::string element =
          name + "[" + std::to_string(row) + "," + std::to_string(col) + "]";
      if (field.complex)
        text.append(",\"Re ").append(element).append("\",\"Im ").append(element).append("\"");
      else
        text.append(",\"").append(element).append("\"");
    }
  }
}

/// Appends "step,time,Q[1,1],...", for ensembles with "Q[member][1,1]" and members counted from 0.
/// The names are quoted because they contain commas.
void append_header(std::string& text, const SampleView& sample) {
  text += "step,time";
  for (int i = 0; i < sample.field_count(); ++i) {
    const auto field = sample.field(i);
    for (std::size_t member = 0; member < std::max<std::size_t>(1, field.members); ++member) {
      std::string name(field.name);
      if (field.members > 0) name.append("[").append(std::to_string(member)).append("]");
      append_elements(text, name, field);
    }
  }
  text += '\n';
}

/// Writes one line per sample. The format has no place for outcome and diagnosis.
class CsvSink : public Sink {
 public:
  explicit CsvSink(const std::string& path)
      : destination_(path), file_(open_for_writing(destination_.working_path())) {}

  void write(const v1::StreamResponse& batch) override {
    text_.clear();
    for (int i = 0; i < batch.steps_size(); ++i) {
      const SampleView sample(batch, i);
      if (!started_) append_header(text_, sample);
      started_ = true;
      text_ += std::to_string(sample.step()) + ',';
      append_number(text_, sample.time());
      for (int j = 0; j < sample.field_count(); ++j) {
        const auto field = sample.field(j);
        for (std::size_t k = 0; k < field.size(); ++k) {
          text_ += ',';
          append_number(text_, field[k]);
        }
      }
      text_ += '\n';
    }
    cli::write(file_.get(), text_);
  }

  void finish(const nlohmann::ordered_json&) override {
    if (!started_) cli::write(file_.get(), "step,time\n");
    flush(file_.get());
    destination_.commit();
  }

 private:
  Destination destination_;
  File file_;
  std::string text_;
  bool started_ = false;
};

}  // namespace

std::unique_ptr<Sink> make_csv_sink(const std::string& path) {
  return std::make_unique<CsvSink>(path);
}

}  // namespace stiefel::cli
