#pragma once

#include <google/protobuf/descriptor.h>

#include <string>
#include <vector>

namespace stiefel::cli {

/// The messages whose fields the object of a file may have.
using Types = std::vector<const google::protobuf::Descriptor*>;

/// Returns the name of a field in files: the proto's json_name if it has one, else the field's
/// name.
std::string name_of(const google::protobuf::FieldDescriptor* field);

/// Returns the field with a name or a lowerCamelCase name, which protobuf reads too; null if the
/// messages do not have it.
const google::protobuf::FieldDescriptor* find_field(const Types& types, const std::string& name);

/// The file of the messages of what a scene file has beside the fields of a scene.
inline constexpr const char* beside_file = "beside_the_scene.proto";

struct Syntax {
  std::string fault;    ///< the first fault with its path; empty if there is none
  bool nested = false;  ///< whether numbers are given in nested lists: [[1, 0], [0, 1]]
};

/// Finds what protobuf's parser accepts or reports without its place and in its own terms: syntax
/// errors, unknown names, names given twice (protobuf would join the two arrays), and values of a
/// wrong type.
Syntax check_syntax(const std::string& text, const Types& types);

}  // namespace stiefel::cli
