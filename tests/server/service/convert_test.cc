// Every field of a description travels, and no field of the messages is forgotten.
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <set>

#include "server/convert/convert.h"
#include "server/sessions/identity.h"
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

/// Every field is there, whether that makes sense together or not.
v1::Scene filled() {
  v1::Scene scene;
  scene.set_system("a");
  auto& method = *scene.mutable_method();
  method.set_name("b");
  method.set_order(1);
  method.set_substeps(2);
  method.set_arithmetic("c");
  method.set_tolerance(0.5);
  method.set_scalar("d");
  auto& body = *scene.mutable_body();
  double next = 1;
  for (auto* numbers :
       {scene.mutable_inertia(), scene.mutable_inertia_u(), scene.mutable_inertia_v(),
        body.mutable_inertia_tensor(), body.mutable_moments(), body.mutable_attitude(),
        body.mutable_angular_velocity()})
    for (int k = 0; k < 3; ++k) numbers->Add(next++);
  for (const char* name : {"P", "Q"}) {
    auto& block = (*scene.mutable_initial())[name];
    block.set_rows(1);
    block.set_cols(2);
    for (int k = 0; k < 2; ++k) block.add_values(next++);
    if (*name == 'P')
      for (int k = 0; k < 2; ++k) block.add_imaginary(next++);
  }
  scene.set_epsilon(next++);
  scene.set_parameter(next++);
  scene.set_step(next++);
  scene.set_tolerance(next++);
  scene.set_horizon(next++);
  scene.set_members(7);
  return scene;
}

TEST(Convert, KeepsEveryField) {
  const v1::Scene scene = filled();
  v1::Scene again;
  server::to_proto(server::from_proto(scene), &again);
  EXPECT_EQ(again.DebugString(), scene.DebugString());
}

TEST(Convert, ChangesTheIdentityWithEveryFieldOfTheMessage) {
  const auto identity = [](const v1::Scene& scene) {
    return server::identity_of(server::from_proto(scene));
  };
  const std::string whole = identity(filled());
  const auto* type = v1::Scene::descriptor();
  for (int i = 0; i < type->field_count(); ++i) {
    v1::Scene changed = filled();
    changed.GetReflection()->ClearField(&changed, type->field(i));
    if (type->field(i)->name() == "initial_tensors") continue;
    EXPECT_NE(identity(changed), whole) << type->field(i)->name();
  }
}

TEST(Convert, TellsAnAbsentNumberFromZero) {
  v1::Scene scene;
  EXPECT_FALSE(server::from_proto(scene).step);
  scene.set_step(0);
  EXPECT_EQ(server::from_proto(scene).step, 0.0);
}

}  // namespace
}  // namespace stiefel
