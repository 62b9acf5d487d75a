// The methods of methods.inc: their entries in the catalogue, and the rigid body moved by them. One
// file, because they use the same templates.
#include "engine/body/body_by_method_of.h"
#include "engine/motion/method_entry_of.h"
#include "methods/all_methods.h"

namespace stiefel {

#define METHOD(file, Type)                                        \
  MethodEntry file##_method() { return method_entry_of<Type>(); } \
  std::optional<BodyByMethod> body_by_##file() { return body_by_method_of<Type>(); }
#include "engine/methods/methods.inc"
#undef METHOD

}  // namespace stiefel
