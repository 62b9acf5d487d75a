#include <cmath>
#include <span>
#include <vector>

#include "client/cli/input/message_file.h"
#include "client/cli/sinks/destination.h"
#include "client/cli/sinks/sink.h"
#include "stiefel/client/samples.h"

namespace stiefel::cli {
namespace {

using client::SampleView;

/// Appends a number, or null for NaN and the infinities, which JSON does not have.
void append_json(std::string& text, double number) {
  std::isfinite(number) ? append_number(text, number) : void(text += "null");
}

/// The lists around the numbers of a field, from the outermost: their lengths.
std::vector<std::size_t> lengths(const client::FieldView& field) {
  std::vector<std::size_t> all;
  if (field.members) all.push_back(field.members);
  const int axes = kind_of(field.name).axes;
  if (axes == 2) all.push_back(field.rows);
  if (axes > 0) all.push_back(field.cols);
  return all;
}

/// Appends nested lists of every `parts`-th number of a field, beginning with number `at`, which
/// becomes that of the next list.
void append_lists(std::string& text, const client::FieldView& field,
                  std::span<const std::size_t> lengths, std::size_t parts, std::size_t& at) {
  if (lengths.empty()) {
    append_json(text, field[at]);
    at += parts;
    return;
  }
  text += '[';
  for (std::size_t i = 0; i < lengths[0]; ++i) {
    if (i) text += ", ";
    append_lists(text, field, lengths.subspan(1), parts, at);
  }
  text += ']';
}

std::string lists(const client::FieldView& field, std::size_t part, std::size_t parts) {
  std::string text;
  append_lists(text, field, lengths(field), parts, part);
  return text;
}

void append_sample(std::string& text, const SampleView& sample) {
  text += "{\"step\": " + std::to_string(sample.step()) + ", \"time\": ";
  append_json(text, sample.time());
  text += ", \"fields\": {";
  for (int i = 0; i < sample.field_count(); ++i) {
    const auto field = sample.field(i);
    text += (i ? ", " : "") + nlohmann::json(field.name).dump() + ": " +
            (field.complex ? "{\"values\": " + lists(field, 0, 2) +
                                 ", \"imaginary\": " + lists(field, 1, 2) + "}"
                           : lists(field, 0, 1));
  }
  text += "}}";
}

/// Writes {"samples": [...], "outcome": ..., "diagnosis": {...}, "scene": ...}, in the order in
/// which these parts become known. A number of a member that has stopped is null.
class JsonSink : public Sink {
 public:
  explicit JsonSink(const std::string& path) {
    if (path.empty()) return;
    destination_ = std::make_unique<Destination>(path);
    file_ = open_for_writing(destination_->working_path());
  }

  void write(const v1::StreamResponse& batch) override {
    text_.clear();
    description_.take(batch);
    for (int i = 0; i < batch.steps_size(); ++i) {
      text_ += started_ ? ",\n" : "{\"samples\": [\n";
      started_ = true;
      append_sample(text_, SampleView(batch, i));
    }
    cli::write(out(), text_);
  }

  void finish(const nlohmann::ordered_json& report, const nlohmann::ordered_json& ending) override {
    nlohmann::ordered_json last = report;
    if (ending.is_object()) last.update(ending);  // none of a run that was interrupted
    last.update(description_.json());
    // Without its opening brace, the report continues the object that was begun.
    const std::string rest = to_text(last).substr(2);
    cli::write(out(), (started_ ? "],\n" : "{\"samples\": [],\n") + rest + "\n");
    flush(out());
    if (destination_) destination_->commit();
  }

 private:
  std::FILE* out() { return file_ ? file_.get() : stdout; }

  std::unique_ptr<Destination> destination_;
  File file_;
  std::string text_;
  bool started_ = false;
};

}  // namespace

std::unique_ptr<Sink> make_json_sink(const std::string& path) {
  return std::make_unique<JsonSink>(path);
}

}  // namespace stiefel::cli
