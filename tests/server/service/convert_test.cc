// No field of the descriptions and of the messages is forgotten.
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <set>

#include "server/convert/convert.h"
#include "server/convert/place.h"
#include "server/sessions/scene_fields.h"

namespace stiefel {
namespace {

using server::Description, server::for_each_field;

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

using server::Place;

TEST(Place, ViolationsAreAtThePlaceOfTheDescription) {
  const Violations wrong = {{"method.order", "3", ""}, {"initial.Q", "2", ""}, {"step", "0", ""}};
  const auto fields = [&](const Place& place) {
    std::vector<std::string> out;
    for (const auto& violation : place.of(wrong)) out.push_back(violation.field);
    return out;
  };
  using Fields = std::vector<std::string>;
  EXPECT_EQ(fields({}), (Fields{"method.order", "initial.Q", "step"}));
  EXPECT_EQ(fields(Place::inside("scene")),
            (Fields{"scene.method.order", "scene.initial.Q", "scene.step"}));
  EXPECT_EQ(fields(Place::made_of("from").with("method", "method").with("step", "new.step")),
            (Fields{"method.order", "from", "new.step"}));
}

TEST(Place, AViolationOfWhatHasNoFieldThereTellsTheFieldInItsValue) {
  const auto at = [](const Place& place, std::string field) {
    return place.of(Violation{std::move(field), "2", "rule"});
  };
  const Violation inherited = at(Place::made_of("from_session_id"), "initial.Q");
  EXPECT_EQ(inherited.field, "from_session_id");
  EXPECT_EQ(inherited.value, "initial.Q: 2");
  const Violation whole = at(Place::inside("scene"), "");
  EXPECT_EQ(whole.field, "scene");
  EXPECT_EQ(whole.value, "2");
  EXPECT_EQ(at(Place::inside("scene").with("step", "step"), "steps").field, "scene.steps")
      << "a name is a whole name";
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
