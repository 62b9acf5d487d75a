// Changes and joins inputs for libFuzzer as messages, printed as JSON or, less often, in wire
// format.
#include <cstring>

#include "tests/fuzz/mutate_message.h"
#include "tests/fuzz/target.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using namespace stiefel::fuzz;

std::size_t write(const google::protobuf::Message& message, bool wire, std::uint8_t* data,
                  std::size_t max_size) {
  const std::string text = wire ? to_bytes(message) : to_json_text(message);
  if (text.size() > max_size) return 0;
  std::memcpy(data, text.data(), text.size());
  return text.size();
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  std::mt19937 random(seed);
  const auto message = input();
  const bool readable = read({reinterpret_cast<const char*>(data), size}, message.get());
  if (readable || random() % 8 == 0) {  // an input that is no message becomes one
    for (unsigned k = random() % 4 + 1; k > 0; --k) mutate(*message, random);
    if (const std::size_t written = write(*message, random() % 8 == 0, data, max_size))
      return written;
  }
  return LLVMFuzzerMutate(data, size, max_size);
}

extern "C" std::size_t LLVMFuzzerCustomCrossOver(const std::uint8_t* one, std::size_t one_size,
                                                 const std::uint8_t* other, std::size_t other_size,
                                                 std::uint8_t* out, std::size_t max_size,
                                                 unsigned) {
  const auto message = input(), more = input();
  if (!read({reinterpret_cast<const char*>(one), one_size}, message.get()) ||
      !read({reinterpret_cast<const char*>(other), other_size}, more.get()))
    return 0;
  message->MergeFrom(*more);
  return write(*message, false, out, max_size);
}
