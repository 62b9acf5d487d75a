#pragma once

#include <google/protobuf/message.h>

#include <random>

namespace stiefel::fuzz {

/// Changes one thing in the message, anywhere in it: a number, a name, an element more or less.
void mutate(google::protobuf::Message& message, std::mt19937& random);

}  // namespace stiefel::fuzz
