#include "client/cpp/resolved_scene.h"

#include <google/protobuf/reflection.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "stiefel/client/error.h"
#include "stiefel/client/samples.h"

namespace stiefel::client {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr std::string_view initial = "initial.", body = "body.";

std::vector<const FieldDescriptor*> present(const Message& message) {
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  return fields;
}

void clear_what_is_in(const Message& other, Message* message) {
  for (const auto* field : present(other)) message->GetReflection()->ClearField(message, field);
}

void clear_blocks(v1::Scene* scene) {
  scene->clear_initial();
  scene->clear_initial_tensors();
}

}  // namespace

v1::Scene resolved_scene(v1::Scene base, const v1::Scene& filled_in, const Names& cleared,
                         const Names& left_out) {
  const bool new_blocks =
      !filled_in.initial().empty() ||
      std::ranges::any_of(left_out, [](const auto& path) { return path.starts_with(initial); });
  if (new_blocks) clear_blocks(&base);
  for (const auto* field : present(filled_in)) {
    if (field->name() == "body")
      clear_what_is_in(filled_in.body(), base.mutable_body());
    else
      base.GetReflection()->ClearField(&base, field);
  }
  base.MergeFrom(filled_in);
  for (const std::string& name : cleared) {
    if (name == "initial") clear_blocks(&base);
    if (const auto* field = v1::Scene::descriptor()->FindFieldByName(name))
      base.GetReflection()->ClearField(&base, field);
  }
  return base;
}

void set_array(const v1::Field& array, v1::Scene* scene) {
  std::string name = array.name();
  if (name.starts_with(initial)) {
    if (array.value().shape().empty() || array.value().data_type() == v1::DATA_TYPE_INT64)
      throw CorruptReply("the scene's block " + name + " is no matrix");
    const std::string block = name.substr(initial.size());
    scene->mutable_initial_tensors()->erase(block);
    (*scene->mutable_initial())[block] = to_matrix(array.value());
    return;
  }
  Message* message = scene;
  if (name.starts_with(body)) {
    message = scene->mutable_body();
    name.erase(0, body.size());
  }
  const auto* field = message->GetDescriptor()->FindFieldByName(name);
  if (!field || !field->is_repeated() || field->cpp_type() != FieldDescriptor::CPPTYPE_DOUBLE ||
      array.value().data_type() != v1::DATA_TYPE_FLOAT64)
    throw CorruptReply("a scene has no array " + array.name());
  const auto numbers = values(array.value());
  message->GetReflection()->ClearField(message, field);
  message->GetReflection()
      ->GetMutableRepeatedFieldRef<double>(message, field)
      .CopyFrom(google::protobuf::RepeatedField<double>(numbers.begin(), numbers.end()));
}

}  // namespace stiefel::client
