#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace stiefel {

/// Appends numbers to a string of bytes, in their memory representation.
class ByteWriter {
 public:
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void put(Number number) { append(&number, sizeof number); }
  /// Writes the ten bytes of x87's format without the padding that follows them.
  void put(long double number) { append(&number, extended_bytes); }
  /// Writes the number of elements, then the elements.
  template <class Number>
  void put(const std::vector<Number>& numbers) {
    put(static_cast<std::uint64_t>(numbers.size()));
    append(numbers.data(), numbers.size() * sizeof(Number));
  }
  std::string take() { return std::move(bytes_); }

  static constexpr std::size_t extended_bytes = 10;

 private:
  void append(const void* from, std::size_t size) {
    bytes_.append(static_cast<const char*>(from), size);
  }

  std::string bytes_;
};

/// Reads what ByteWriter wrote. When the bytes run out or a count is not the expected one, `sound`
/// becomes false, and further reads leave their arguments unchanged.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : left_(bytes) {}

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void get(Number& number) { copy(&number, sizeof number); }
  void get(bool& flag) {
    std::uint8_t byte = flag;
    get(byte);
    require(byte <= 1);
    flag = byte == 1;
  }
  void get(long double& number) { copy(&number, ByteWriter::extended_bytes); }
  /// Reads as many numbers as the vector has.
  template <class Number>
  void get(std::vector<Number>& numbers) {
    if (count() == numbers.size())
      copy(numbers.data(), numbers.size() * sizeof(Number));
    else
      sound_ = false;
  }
  /// Reads a vector of up to `most` numbers.
  template <class Number>
  void get_up_to(std::size_t most, std::vector<Number>& numbers) {
    const std::uint64_t size = count();
    if (size > most || size * sizeof(Number) > left_.size()) sound_ = false;
    if (!sound_) return;
    numbers.resize(size);
    copy(numbers.data(), size * sizeof(Number));
  }

  /// Makes `sound` false where what was read breaks a rule.
  void require(bool rule) { sound_ = sound_ && rule; }
  bool sound() const { return sound_; }
  /// Whether everything was read without a fault.
  bool complete() const { return sound_ && left_.empty(); }

 private:
  std::uint64_t count() {
    std::uint64_t size = 0;
    get(size);
    return size;
  }
  void copy(void* to, std::size_t size) {
    if (size > left_.size()) sound_ = false;
    if (!sound_ || size == 0) return;
    std::memcpy(to, left_.data(), size);
    left_.remove_prefix(size);
  }

  std::string_view left_;
  bool sound_ = true;
};

}  // namespace stiefel
