// Arrays that travel in parts, and the scene that they belong to.
#include "client/cpp/assembly.h"

#include <gtest/gtest.h>

#include "client/cpp/resolved_scene.h"
#include "stiefel/client/error.h"
#include "stiefel/client/samples.h"

namespace stiefel::client {
namespace {

v1::Tensor tensor(const std::vector<std::uint64_t>& shape, const std::vector<double>& numbers) {
  v1::Tensor tensor;
  tensor.mutable_shape()->Add(shape.begin(), shape.end());
  tensor.set_data_type(v1::DATA_TYPE_FLOAT64);
  tensor.set_data(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double));
  return tensor;
}

/// Numbers `offset`, `offset` + 1, ... of an array of shape (2, 3) that counts from 0.
v1::Field part(const std::string& name, std::uint64_t offset, std::size_t size) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < size; ++i) numbers.push_back(static_cast<double>(offset + i));
  v1::Field field;
  field.set_name(name);
  *field.mutable_value() = tensor({size}, numbers);
  field.add_whole_shape(2);
  field.add_whole_shape(3);
  field.set_offset(offset);
  return field;
}

Fields assembled(std::vector<v1::Field> fields) {
  Assembly assembly;
  for (auto& field : fields) assembly.take(&field);
  return assembly.finish();
}

TEST(Assembly, JoinsPartsAndPassesWholeArraysThrough) {
  v1::Field whole;
  whole.set_name("whole");
  *whole.mutable_value() = tensor({1}, {7});
  const Fields fields =
      assembled({part("a", 0, 4), part("a", 4, 2), whole, part("b", 0, 3), part("b", 3, 3)});
  ASSERT_EQ(fields.size(), 3);
  const std::vector<double> expected = {0, 1, 2, 3, 4, 5};
  for (const int i : {0, 2}) {
    EXPECT_EQ(fields[i].name(), i == 0 ? "a" : "b");
    EXPECT_EQ(fields[i].value().shape_size(), 2);
    const auto numbers = values(fields[i].value());
    EXPECT_EQ(std::vector(numbers.begin(), numbers.end()), expected);
    EXPECT_TRUE(fields[i].whole_shape().empty());
  }
  EXPECT_EQ(fields[1].SerializeAsString(), whole.SerializeAsString());
}

TEST(Assembly, NoticesWhatIsMissing) {
  EXPECT_THROW(assembled({part("a", 0, 4)}), CorruptReply);
  EXPECT_THROW(assembled({part("a", 4, 2)}), CorruptReply);
  EXPECT_THROW(assembled({part("a", 0, 3), part("a", 4, 2)}), CorruptReply);
  EXPECT_THROW(assembled({part("a", 0, 4), part("b", 4, 2)}), CorruptReply);
  EXPECT_THROW(assembled({part("a", 0, 4), part("a", 4, 2), part("a", 6, 2)}), CorruptReply);
  v1::Field vast = part("a", 0, 4);
  vast.set_whole_shape(0, ~std::uint64_t{0});
  EXPECT_THROW(assembled({vast}), CorruptReply);
}

v1::Scene sent() {
  v1::Scene scene;
  scene.set_system("rigid_body");
  scene.set_tolerance(1e-6);
  scene.set_horizon(2);
  scene.add_inertia(3);
  scene.add_inertia(2);
  scene.mutable_body()->add_moments(1);
  scene.mutable_body()->add_angular_velocity(5);
  (*scene.mutable_initial_tensors())["Q"] = tensor({1, 1}, {1});
  return scene;
}

TEST(ResolvedScene, HasWhatWasFilledInInThePlaceOfWhatWasSent) {
  v1::Scene filled_in;
  filled_in.mutable_method()->set_name("rk4");
  filled_in.add_inertia(9);
  filled_in.mutable_body()->add_attitude(1);
  filled_in.mutable_body()->add_moments(4);
  Names cleared;
  *cleared.Add() = "tolerance";
  const v1::Scene scene = resolved_scene(sent(), filled_in, cleared, {});
  EXPECT_EQ(scene.method().name(), "rk4");
  EXPECT_FALSE(scene.has_tolerance());
  EXPECT_EQ(scene.horizon(), 2);
  ASSERT_EQ(scene.inertia_size(), 1);
  EXPECT_EQ(scene.inertia(0), 9);
  ASSERT_EQ(scene.body().moments_size(), 1);
  EXPECT_EQ(scene.body().moments(0), 4);
  EXPECT_EQ(scene.body().angular_velocity(0), 5);
  EXPECT_EQ(scene.initial_tensors().size(), 1u);
}

TEST(ResolvedScene, TakesBlocksAllTogether) {
  v1::Scene filled_in;
  (*filled_in.mutable_initial())["P"].add_values(1);
  v1::Scene scene = resolved_scene(sent(), filled_in, {}, {});
  EXPECT_TRUE(scene.initial_tensors().empty());
  EXPECT_EQ(scene.initial().size(), 1u);
  Names left_out;
  *left_out.Add() = "initial.P";
  scene = resolved_scene(sent(), {}, {}, left_out);
  EXPECT_TRUE(scene.initial_tensors().empty());
}

TEST(ResolvedScene, TakesArraysByTheirPaths) {
  v1::Scene scene = sent();
  v1::Field array;
  array.set_name("initial.Q");
  *array.mutable_value() = tensor({2, 1, 2}, {1, 2, 3, 4});
  set_array(array, &scene);
  EXPECT_TRUE(scene.initial_tensors().empty());
  EXPECT_EQ(scene.initial().at("Q").rows(), 2u);
  EXPECT_EQ(scene.initial().at("Q").values(3), 4);
  array.set_name("body.attitude");
  set_array(array, &scene);
  EXPECT_EQ(scene.body().attitude_size(), 4);
  array.set_name("mass");
  EXPECT_THROW(set_array(array, &scene), CorruptReply);
}

}  // namespace
}  // namespace stiefel::client
