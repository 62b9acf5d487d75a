#include "tests/fuzz/mutate_message.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "stiefel/catalogue.h"
#include "stiefel/conversion.h"

namespace stiefel::fuzz {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using Random = std::mt19937;

std::size_t below(std::size_t n, Random& random) { return random() % n; }
template <class Items>
const auto& any_of(const Items& items, Random& random) {
  return items[below(std::size(items), random)];
}

/// Every name that the service knows, so that few cases are refused for a name.
const std::vector<std::string>& names() {
  static const auto all = [] {
    std::vector<std::string> out = {"a",
                                    "b",
                                    "",
                                    "plain",
                                    "compensated",
                                    "velocity",
                                    "interpolation",
                                    "angular_velocity",
                                    "no such name"};
    for (const auto& method : catalogue().methods) out.emplace_back(method.name);
    for (const auto& system : catalogue().systems) {
      out.emplace_back(system.name);
      for (const auto& block : system.blocks) out.emplace_back(block.name);
      for (const auto& field : system.fields) out.emplace_back(field.name);
      for (const auto& invariant : system.invariants) out.emplace_back(invariant.name);
      for (const auto& form : system.forms) out.emplace_back(form.name);
    }
    return out;
  }();
  return all;
}

double changed(double x, Random& random) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  constexpr double edges[] = {0,
                              1,
                              -1,
                              0.5,
                              2,
                              5e-324,
                              1e-300,
                              1e-160,
                              1e-20,
                              1e20,
                              1e150,
                              1e160,
                              1e300,
                              1e308,
                              infinity,
                              -infinity,
                              std::numeric_limits<double>::quiet_NaN()};
  switch (below(6, random)) {
    case 0:
      return any_of(edges, random);
    case 1:
      return -x;
    case 2:
      return x + std::ldexp(1.0, -static_cast<int>(below(53, random)));
    case 3:
      return x * std::ldexp(1.0, static_cast<int>(below(41, random)) - 20);
    case 4:
      return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) ^ std::uint64_t{1}
                                                                         << below(64, random));
    default:
      return static_cast<double>(below(33, random)) / 16 - 1;
  }
}

std::uint64_t changed(std::uint64_t k, Random& random) {
  constexpr std::uint64_t edges[] = {0,   1,        2,   3,          4,          8,
                                     100, 1u << 31, ~0u, 1ull << 53, 1ull << 63, ~0ull};
  switch (below(3, random)) {
    case 0:
      return any_of(edges, random);
    case 1:
      return k + 1 - 2 * below(2, random);
    default:
      return k ^ 1ull << below(64, random);
  }
}

std::string changed(std::string text, bool bytes, Random& random) {
  if (!bytes && below(4, random) > 0) return any_of(names(), random);
  if (text.empty() || below(3, random) == 0) text.insert(below(text.size() + 1, random), 1, 'x');
  text[below(text.size(), random)] = static_cast<char>(below(bytes ? 256 : 128, random));
  return text;
}

/// Sets the field, or element `i` of it, to something else.
void change(Message& message, const FieldDescriptor* field, int i, Random& random) {
  const Reflection& r = *message.GetReflection();
  const bool many = field->is_repeated();
#define STIEFEL_CHANGE(Type, change_to)                                                           \
  {                                                                                               \
    const auto old = many ? r.GetRepeated##Type(message, field, i) : r.Get##Type(message, field); \
    many ? r.SetRepeated##Type(&message, field, i, change_to)                                     \
         : r.Set##Type(&message, field, change_to);                                               \
    return;                                                                                       \
  }
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      STIEFEL_CHANGE(Double, changed(old, random))
    case FieldDescriptor::CPPTYPE_BOOL:
      STIEFEL_CHANGE(Bool, !old)
    case FieldDescriptor::CPPTYPE_INT32:
      STIEFEL_CHANGE(Int32,
                     static_cast<std::int32_t>(changed(static_cast<std::uint64_t>(old), random)))
    case FieldDescriptor::CPPTYPE_INT64:
      STIEFEL_CHANGE(Int64,
                     static_cast<std::int64_t>(changed(static_cast<std::uint64_t>(old), random)))
    case FieldDescriptor::CPPTYPE_UINT32:
      STIEFEL_CHANGE(UInt32, static_cast<std::uint32_t>(changed(std::uint64_t{old}, random)))
    case FieldDescriptor::CPPTYPE_UINT64:
      STIEFEL_CHANGE(UInt64, changed(std::uint64_t{old}, random))
    case FieldDescriptor::CPPTYPE_STRING:
      STIEFEL_CHANGE(String, changed(old, field->type() == FieldDescriptor::TYPE_BYTES, random))
    case FieldDescriptor::CPPTYPE_MESSAGE:
      if (!many) r.MutableMessage(&message, field);
      return;
    default:
      return;
  }
#undef STIEFEL_CHANGE
}

void add(Message& message, const FieldDescriptor* field, Random& random) {
  const Reflection& r = *message.GetReflection();
  const int size = r.FieldSize(message, field);
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return r.AddDouble(&message, field, changed(0.0, random));
    case FieldDescriptor::CPPTYPE_STRING:
      return r.AddString(&message, field, any_of(names(), random));
    case FieldDescriptor::CPPTYPE_MESSAGE: {
      Message* added = r.AddMessage(&message, field);
      if (size > 0)
        added->CopyFrom(r.GetRepeatedMessage(
            message, field, static_cast<int>(below(static_cast<std::size_t>(size), random))));
      return;
    }
    default:
      return;
  }
}

void change_list(Message& message, const FieldDescriptor* field, Random& random) {
  const Reflection& r = *message.GetReflection();
  const int size = r.FieldSize(message, field);
  const auto any = [&] { return static_cast<int>(below(static_cast<std::size_t>(size), random)); };
  switch (size == 0 ? 0 : below(6, random)) {
    case 0:
      return add(message, field, random);
    case 1:
      return r.RemoveLast(&message, field);
    case 2:
      return r.SwapElements(&message, field, any(), any());
    default:
      return change(message, field, any(), random);
  }
}

/// The message and all that are in it.
void collect(Message& message, std::vector<Message*>& out) {
  out.push_back(&message);
  const Reflection& r = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  r.ListFields(message, &fields);
  for (const auto* field : fields) {
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated()) {
      collect(*r.MutableMessage(&message, field), out);
      continue;
    }
    for (int i = 0; i < r.FieldSize(message, field); ++i)
      collect(*r.MutableRepeatedMessage(&message, field, i), out);
  }
}

}  // namespace

void mutate(Message& message, Random& random) {
  std::vector<Message*> all;
  collect(message, all);
  Message& one = *any_of(all, random);
  const auto* type = one.GetDescriptor();
  if (type->field_count() == 0) return;
  const auto* field =
      type->field(static_cast<int>(below(static_cast<std::size_t>(type->field_count()), random)));
  if (field->is_repeated()) return change_list(one, field, random);
  if (below(6, random) == 0) return one.GetReflection()->ClearField(&one, field);
  change(one, field, 0, random);
}

}  // namespace stiefel::fuzz
