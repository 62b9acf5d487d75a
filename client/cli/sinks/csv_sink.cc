#include <algorithm>

#include "client/cli/sinks/destination.h"
#include "client/cli/sinks/sink.h"
#include "stiefel/client/samples.h"

namespace stiefel::cli {
namespace {

using client::SampleView;

std::string index(std::size_t i) { return "[" + std::to_string(i) + "]"; }

/// Returns the column of number (row, col) of a field: "q_w", "q[0]", "epsilon" or "Q[0,0]", of a
/// member "q_w[2]", "q[2][0]", "epsilon[2]" or "Q[2][0,0]".
std::string column(const client::FieldView& field, std::size_t member, std::size_t row,
                   std::size_t col) {
  const FieldKind& kind = kind_of(field.name);
  const std::string of_member = field.members > 0 ? index(member) : "";
  const std::string name(field.name);
  if (col < kind.columns.size()) return std::string(kind.columns[col]) + of_member;
  if (kind.axes == 0) return name + of_member;
  if (kind.axes == 1) return name + of_member + index(col);
  return name + of_member + "[" + std::to_string(row) + "," + std::to_string(col) + "]";
}

/// Appends ",NAME"; a name that contains a comma in quotes.
void append_name(std::string& text, const std::string& name) {
  const char* quote = name.find(',') == std::string::npos ? "" : "\"";
  text.append(",").append(quote).append(name).append(quote);
}

/// Appends the names of all columns: "step,time,q_w,...". Everything is counted from 0.
void append_header(std::string& text, const SampleView& sample) {
  text += "step,time";
  for (int i = 0; i < sample.field_count(); ++i) {
    const auto field = sample.field(i);
    for (std::size_t member = 0; member < std::max<std::size_t>(1, field.members); ++member) {
      for (std::size_t row = 0; row < field.rows; ++row) {
        for (std::size_t col = 0; col < field.cols; ++col) {
          const std::string name = column(field, member, row, col);
          append_name(text, (field.complex ? "Re " : "") + name);
          if (field.complex) append_name(text, "Im " + name);
        }
      }
    }
  }
  text += '\n';
}

/// Appends the line of the units of all columns, as the line of their names has them.
void append_units(std::string& text, const SampleView& sample, const Description& description) {
  text += "# units: 1," + description.unit_of("time");
  for (int i = 0; i < sample.field_count(); ++i) {
    const auto field = sample.field(i);
    for (std::size_t k = 0; k < field.size(); ++k) text += ',' + description.unit_of(field.name);
  }
  text += '\n';
}

/// Writes one line per sample. Lines that begin with # tell the scene and the units and, at the
/// end, how the run ended.
class CsvSink : public Sink {
 public:
  explicit CsvSink(const std::string& path)
      : destination_(path), file_(open_for_writing(destination_.working_path())) {}

  void write(const v1::StreamResponse& batch) override {
    text_.clear();
    description_.take(batch);
    for (int i = 0; i < batch.steps_size(); ++i) {
      const SampleView sample(batch, i);
      if (!started_) {
        text_ += "# " + description_.json().dump() + '\n';
        append_units(text_, sample, description_);
        append_header(text_, sample);
      }
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

  void finish(const nlohmann::ordered_json&, const nlohmann::ordered_json& ending) override {
    if (!started_)
      cli::write(file_.get(), "# " + description_.json().dump() + "\n# units: 1,s\nstep,time\n");
    cli::write(file_.get(), "# " + ending.dump() + '\n');
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
