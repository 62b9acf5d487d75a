// No field of the descriptions and of the messages is forgotten.
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <set>

#include "server/convert/convert.h"
#include "stiefel/scene_fields.h"

namespace stiefel {
namespace {

template <Description T>
std::set<std::string> names() {
  std::set<std::string> out;
  for_each_field<T>([&](const auto& field) { out.insert(std::string(field.name)); });
  return out;
}

template <class Message>
std::set<std::string> names_on_the_wire() {
  std::set<std::string> out;
  for (int i = 0; i < Message::descriptor()->field_count(); ++i)
    out.insert(Message::descriptor()->field(i)->name());
  return out;
}

TEST(Convert, DescriptionsAndMessagesHaveTheSameFields) {
  EXPECT_EQ(names<MethodDescription>(), names_on_the_wire<v1::Method>());
  EXPECT_EQ(names<BodyDescription>(), names_on_the_wire<v1::Body>());
  auto scene = names<SceneDescription>();
  scene.insert("initial_tensors");  // of the same blocks
  EXPECT_EQ(scene, names_on_the_wire<v1::Scene>());
}

TEST(Convert, TellsAnAbsentNumberFromZero) {
  v1::Scene scene;
  EXPECT_FALSE(server::from_proto(scene).step);
  scene.set_step(0);
  EXPECT_EQ(server::from_proto(scene).step, 0.0);
}

}  // namespace
}  // namespace stiefel
