#include "server/convert/messages.h"

#include <algorithm>

#include "server/convert/convert.h"
#include "server/sessions/field_bytes.h"

namespace stiefel::server {
namespace {

v1::Field field_of(const SummaryArray& array) {
  v1::Field field;
  field.set_name(array.name);
  v1::Tensor& tensor = *field.mutable_value();
  for (const std::size_t extent : array.shape) tensor.add_shape(extent);
  if (array.type != SummaryArray::Type::count) {
    tensor.set_data_type(array.type == SummaryArray::Type::complex ? v1::DATA_TYPE_COMPLEX128
                                                                   : v1::DATA_TYPE_FLOAT64);
    tensor.set_data(array.numbers.data(), array.numbers.size() * sizeof(double));
    return field;
  }
  std::vector<std::int64_t> counts = array.counts;
  if (array.name == "outcome")
    for (std::int64_t& count : counts)
      count = same_order(static_cast<Outcome>(count), v1::OUTCOME_REACHED);
  tensor.set_data_type(v1::DATA_TYPE_INT64);
  tensor.set_data(counts.data(), counts.size() * sizeof(std::int64_t));
  return field;
}

}  // namespace

SummaryMessages::SummaryMessages(const Session& session, const SummaryDescription& what)
    : session_(session), members_(std::max<std::size_t>(1, session.scene().members().size())) {
  for (const std::string& name : what.fields)
    fields_.push_back(find_field(session.fields(), name).value());
  if (fields_.empty()) fields_ = session.default_fields();
  for (const std::size_t index : fields_)
    event_numbers_ += field_size(session.fields(), index) / members_;
}

void SummaryMessages::add(std::vector<Event> events) {
  std::ranges::move(events, std::back_inserter(events_));
}

void SummaryMessages::add(std::vector<StateAtTime> states) {
  std::ranges::move(states, std::back_inserter(states_));
}

void SummaryMessages::add(const std::vector<SummaryArray>& statistics) {
  for (const SummaryArray& array : statistics) *statistics_.Add() = field_of(array);
}

template <class Items, class Batch, class Write>
void SummaryMessages::take(Items& items, bool by_members, Batch& batch, const Write& write) {
  constexpr std::size_t list_bytes = 40;  // of steps, times and the like
  const std::size_t each = (by_members ? state_bytes() : event_bytes()) + list_bytes;
  const std::size_t count =
      std::min(items.size(), std::max<std::size_t>(1, Sampling::batch_bytes / each));
  std::size_t from = 0;
  for (const std::size_t index : fields_) {
    const std::size_t size = field_size(session_.fields(), index) / (by_members ? 1 : members_);
    v1::Field& field = *batch.add_fields();
    describe_field(session_, index, count, !by_members, &field);
    const bool narrow = is_float(session_, index);
    std::string& data = *field.mutable_value()->mutable_data();
    data.reserve(count * size * (narrow ? sizeof(float) : sizeof(double)));
    for (std::size_t i = 0; i < count; ++i) {
      const double* one = items[i].fields.data() + from;
      if (!narrow) data.append(reinterpret_cast<const char*>(one), size * sizeof(double));
      for (std::size_t k = 0; narrow && k < size; ++k) {
        const auto number = static_cast<float>(one[k]);
        data.append(reinterpret_cast<const char*>(&number), sizeof number);
      }
    }
    from += size;
  }
  const auto end = items.begin() + static_cast<std::ptrdiff_t>(count);
  std::for_each(items.begin(), end, write);
  items.erase(items.begin(), end);
}

void SummaryMessages::next(v1::SummarizeResponse& message) {
  if (!events_.empty()) {
    auto& batch = *message.mutable_events();
    take(events_, false, batch, [&](const Event& event) {
      batch.add_events(static_cast<std::uint32_t>(event.event));
      batch.add_steps(event.step);
      batch.add_fractions(event.fraction);
      batch.add_times(event.time);
      if (!session_.scene().members().empty())
        batch.add_members(static_cast<std::uint32_t>(event.member));
    });
  } else if (!states_.empty()) {
    auto& batch = *message.mutable_states();
    take(states_, true, batch, [&](const StateAtTime& state) {
      batch.add_steps(state.step);
      batch.add_times(state.time);
    });
  } else if (!checkpoint_.data().empty()) {
    message.mutable_checkpoint()->Swap(&checkpoint_);
  } else {
    message.mutable_statistics()->Swap(&statistics_);
  }
}

}  // namespace stiefel::server
