#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <span>

#include "client/cli/page/run_data.h"

namespace stiefel::cli {
namespace {

constexpr double finest = 0.1;                 ///< radians between two samples
constexpr double fewest = 500, most = 12'000;  ///< samples
constexpr double most_bytes = 1.1e6;           ///< of all samples in single precision
constexpr std::size_t largest = 8;             ///< rows and columns that are shown of a matrix

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three =
          three << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : digits[three >> (18 - 6 * k) & 63];
  }
  return text;
}

/// The samples of one field, of one member and without the rows and columns that are not shown.
struct Column {
  std::size_t rows = 0, cols = 0;
  bool complex = false;
  std::vector<float> values;

  void add(const client::FieldView& field, std::size_t member) {
    rows = std::min(field.rows, largest);
    cols = std::min(field.cols, largest);
    complex = field.complex;
    const std::size_t parts = complex ? 2 : 1;
    const std::size_t first = field.members ? member * field.rows * field.cols * parts : 0;
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < cols * parts; ++j)
        values.push_back(static_cast<float>(field[first + i * field.cols * parts + j]));
  }
};

struct Samples {
  std::size_t member;
  std::vector<double> times = {};
  std::map<std::string, Column> fields = {};

  void add(const v1::StreamResponse& batch) {
    for (int k = 0; k < batch.steps_size(); ++k) {
      const client::SampleView sample(batch, k);
      times.push_back(sample.time());
      for (int i = 0; i < sample.field_count(); ++i) {
        const auto field = sample.field(i);
        fields[std::string(field.name)].add(field, member);
      }
    }
  }

  nlohmann::ordered_json json() const {
    nlohmann::ordered_json out = {
        {"time", {{"dtype", "float64"}, {"data", base64(std::as_bytes(std::span(times)))}}},
        {"fields", nlohmann::ordered_json::object()}};
    for (const auto& [name, column] : fields)
      out["fields"][name] = {{"rows", column.rows},
                             {"cols", column.cols},
                             {"complex", column.complex},
                             {"dtype", "float32"},
                             {"data", base64(std::as_bytes(std::span(column.values)))}};
    return out;
  }
};

std::vector<std::string> drawn_fields(const v1::Scene& scene, const v1::SystemInfo& system) {
  const auto has = [&](std::string_view name) {
    return std::ranges::any_of(system.fields(),
                               [&](const v1::FieldInfo& field) { return field.name() == name; });
  };
  std::vector<std::string> names;
  for (const char* frame : {"Q", "q"}) {
    const bool given = scene.has_body() || scene.initial().contains(frame) ||
                       scene.initial_tensors().contains(frame);
    if (given && has(frame)) names.push_back(frame);
  }
  for (const char* rate : {"Qdot", "M", "P"}) {
    if (!has(rate)) continue;
    names.push_back(rate);
    break;
  }
  return names;
}

void take_at_times(const client::Session& session, const std::vector<std::string>& fields,
                   double end, std::int64_t count, Samples& samples) {
  v1::SummarizeRequest request;
  for (std::int64_t k = 0; k <= count; ++k)
    request.add_times(end * static_cast<double>(k) / static_cast<double>(count));
  request.set_to(
      static_cast<std::int64_t>(std::ceil(end / session.scene().step() * (1 - 0x1p-50))));
  request.set_every(std::max<std::int64_t>(1, request.to()));
  request.mutable_fields()->Add(fields.begin(), fields.end());
  session.summarize(request, [&](const v1::SummarizeResponse& message) {
    v1::StreamResponse batch;
    *batch.mutable_steps() = message.states().steps();
    *batch.mutable_times() = message.states().times();
    *batch.mutable_fields() = message.states().fields();
    samples.add(batch);
    return true;
  });
}

}  // namespace

nlohmann::ordered_json draw_samples(const client::Session& session, const v1::SystemInfo& system,
                                    const RunData& run, std::size_t member) {
  const auto& scene = session.scene();
  const auto fields = drawn_fields(scene, system);
  const std::int64_t to = run.last.step();
  Samples first{.member = member}, samples{.member = member};
  const auto take = [&](Samples& into, std::int64_t end, std::int64_t every) {
    auto stream = session.stream({.to = end, .every = every, .fields = fields});
    while (const auto* batch = stream.next_batch()) into.add(*batch);
  };
  take(first, 0, 1);
  std::size_t numbers = 1;
  for (const auto& [name, column] : first.fields) numbers += column.values.size();
  if (to == 0) return first.json();

  const double step = std::abs(scene.step()), end = std::abs(run.last.time());
  const double limit =
      std::min(most, std::floor(most_bytes / (4.0 * static_cast<double>(numbers))));
  const double between = run.speed > 0 ? finest / run.speed : 0;
  const double shown = between > 0 ? std::min(end, limit * between) : end;
  const double count =
      std::clamp(between > 0 ? std::ceil(shown / between) : fewest, std::min(fewest, limit), limit);
  const double every = shown / count / step;
  if (every >= 1 || !scene.has_method()) {
    take(samples, std::min(to, static_cast<std::int64_t>(std::ceil(shown / step))),
         static_cast<std::int64_t>(std::ceil(every)));
  } else {
    take_at_times(session, fields, std::copysign(shown, scene.step()),
                  static_cast<std::int64_t>(count), samples);
  }
  return samples.json();
}

}  // namespace stiefel::cli
