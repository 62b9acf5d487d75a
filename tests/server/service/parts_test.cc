#include "server/convert/parts.h"

#include <gtest/gtest.h>

#include <numeric>

namespace stiefel::server {
namespace {

v1::Field field(const std::string& name, std::vector<std::uint64_t> shape, v1::DataType type,
                std::size_t number) {
  v1::Field out;
  out.set_name(name);
  out.mutable_value()->set_data_type(type);
  std::size_t size = number;
  for (const auto extent : shape) {
    out.mutable_value()->add_shape(extent);
    size *= extent;
  }
  std::string& data = *out.mutable_value()->mutable_data();
  data.resize(size);
  for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<char>(i * 37 % 251);
  return out;
}

/// The messages' fields, none larger than the budget.
std::vector<Parts::Fields> taken(Parts parts, std::size_t budget) {
  std::vector<Parts::Fields> messages;
  while (!parts.empty()) {
    parts.take(budget, &messages.emplace_back());
    std::size_t bytes = 0;
    for (const auto& part : messages.back()) bytes += part.value().data().size();
    EXPECT_LE(bytes, budget);
    EXPECT_GT(bytes, 0u);
  }
  return messages;
}

TEST(Parts, KeepWholeWhatFits) {
  Parts parts;
  parts.add(field("a", {2, 3}, v1::DATA_TYPE_FLOAT64, 8));
  parts.add(field("b", {3, 3}, v1::DATA_TYPE_FLOAT64, 8));
  parts.add(field("c", {4, 2}, v1::DATA_TYPE_FLOAT64, 8));
  const auto messages = taken(parts, 128);
  ASSERT_EQ(messages.size(), 2u);
  ASSERT_EQ(messages[0].size(), 2);
  EXPECT_EQ(messages[0][1].name(), "b");
  EXPECT_EQ(messages[1][0].name(), "c");
  for (const auto& message : messages)
    for (const auto& part : message) EXPECT_EQ(part.whole_shape_size(), 0);
}

TEST(Parts, EndWithRowsAndAddUp) {
  for (const auto& [type, number] :
       {std::pair(v1::DATA_TYPE_FLOAT64, 8), std::pair(v1::DATA_TYPE_COMPLEX128, 16),
        std::pair(v1::DATA_TYPE_FLOAT32, 4)}) {
    const auto size = static_cast<std::size_t>(number);
    const v1::Field whole = field("Q", {1, 3, 7, 5}, type, size);
    Parts parts;
    parts.add(whole);
    const auto messages = taken(parts, 13 * 5 * size + 3);
    ASSERT_EQ(messages.size(), 2u);
    std::string data;
    for (const auto& message : messages) {
      const v1::Field& part = message[0];
      EXPECT_EQ(part.name(), "Q");
      EXPECT_EQ(part.offset() * size, data.size());
      EXPECT_EQ(part.value().shape(0) * size, part.value().data().size());
      EXPECT_EQ(part.value().shape(0) % 5, 0u) << "rows";
      EXPECT_EQ(part.value().data_type(), type);
      EXPECT_TRUE(std::ranges::equal(part.whole_shape(), whole.value().shape()));
      data += part.value().data();
    }
    EXPECT_EQ(data, whole.value().data());
  }
}

TEST(Parts, CutARowThatDoesNotFit) {
  const v1::Field whole = field("q", {1, 1000}, v1::DATA_TYPE_COMPLEX128, 16);
  Parts parts;
  parts.add(whole);
  std::string data;
  for (const auto& message : taken(parts, 1000)) {
    EXPECT_EQ(message[0].value().data().size() % 16, 0u) << "numbers stay whole";
    data += message[0].value().data();
  }
  EXPECT_EQ(data, whole.value().data());
}

}  // namespace
}  // namespace stiefel::server
