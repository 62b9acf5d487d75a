// Runs a fuzz target on files, in a build without libFuzzer: replay [--mutations=K] FILE... With K
// also on K seeded changes of each, the same ones every time. The last changed input is in the file
// last-NAME.json of the working directory when the target has aborted.
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <string_view>

#include "tests/fuzz/mutate_message.h"
#include "tests/fuzz/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using namespace stiefel::fuzz;

void run_changed(const google::protobuf::Message& seed, unsigned number) {
  std::mt19937 random(number);
  const auto message = input();
  message->CopyFrom(seed);
  for (unsigned k = random() % 4 + 1; k > 0; --k) mutate(*message, random);
  const std::string last = "last-" + message->GetDescriptor()->name() + ".json";
  std::ofstream(last) << to_json_text(*message);
  run(*message);
  std::filesystem::remove(last);
}

}  // namespace

int main(int argc, char** argv) {
  unsigned mutations = 0;
  constexpr std::string_view option = "--mutations=";
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument.starts_with(option)) {
      std::from_chars(argument.data() + option.size(), argument.data() + argument.size(),
                      mutations);
      continue;
    }
    std::cout << argument << std::endl;
    std::ifstream file(argv[i], std::ios::binary);
    if (!file) return 1;
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    const auto seed = input();
    if (!read(bytes, seed.get())) continue;
    for (unsigned k = 0; k < mutations; ++k) run_changed(*seed, k);
  }
  return argc > 1 ? 0 : 1;
}
