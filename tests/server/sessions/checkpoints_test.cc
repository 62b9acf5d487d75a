#include "server/sessions/checkpoints/checkpoints.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/checkpoints/secrets.h"
#include "server/sessions/cursor.h"
#include "tests/server/scene_cases.h"

namespace stiefel::server {
namespace {

Saved numbers(std::size_t count) { return std::make_shared<const std::vector<double>>(count); }

TEST(Checkpoints, ThinByDoublingTheSpacing) {
  Checkpoints checkpoints(10);
  for (std::int64_t step = 0; step <= 10'000; step += 10) {
    checkpoints.put(step, numbers(4));
    ASSERT_LE(checkpoints.steps().size(), Checkpoints::max_count);
    ASSERT_EQ(checkpoints.steps().front(), 0);
  }
  EXPECT_EQ(checkpoints.spacing(), 160);
  EXPECT_EQ(checkpoints.steps().size(), 63u);
  EXPECT_EQ(checkpoints.nearest(9'999).step, 9'920);
  EXPECT_EQ(checkpoints.nearest(159).step, 0);

  Checkpoints large(1);
  const std::size_t quarter = Checkpoints::max_bytes / sizeof(double) / 4;
  for (std::int64_t step = 0; step <= 20; ++step) large.put(step, numbers(quarter));
  EXPECT_LE(large.steps().size(), 4u);
  EXPECT_EQ(large.steps().front(), 0);
}

TEST(Checkpoints, KeepTheEarliestAndTheNewestRestoredOne) {
  using Steps = std::vector<std::int64_t>;
  Checkpoints checkpoints(10);
  checkpoints.put(0, numbers(4));
  checkpoints.restore(33, numbers(4));
  checkpoints.restore(77, numbers(4));
  for (std::int64_t step = 10; step <= 100'000; step += 10) checkpoints.put(step, numbers(4));
  EXPECT_EQ(checkpoints.nearest(150).step, 77);
  checkpoints.evict();
  EXPECT_EQ(checkpoints.evictable(), 0u);
  EXPECT_EQ(checkpoints.steps(), (Steps{0, 33, 77}));
  for (const auto& [step, steps] :
       {std::pair{55, Steps{0, 33, 55}}, std::pair{99, Steps{0, 33, 99}},
        std::pair{20, Steps{0, 20, 99}}, std::pair{99, Steps{0, 20, 99}}}) {
    checkpoints.restore(step, numbers(4));
    EXPECT_EQ(checkpoints.steps(), steps);
  }
}

TEST(Checkpoints, ARestoredOneIsShed) {
  Checkpoints checkpoints(10);
  checkpoints.put(0, numbers(4));
  checkpoints.restore(33, numbers(4), false);
  checkpoints.restore(77, numbers(4), false);
  EXPECT_EQ(checkpoints.evictable(), 2u);
  checkpoints.restore(33, numbers(4));
  EXPECT_EQ(checkpoints.evictable(), 1u) << "a client brought it again";
  checkpoints.evict();
  EXPECT_EQ(checkpoints.steps(), (std::vector<std::int64_t>{0, 33}));
  EXPECT_EQ(checkpoints.evictable(), 0u);
}

TEST(Checkpoints, TheLaterRestoredOneStaysWhereOneFits) {
  const std::size_t half = Checkpoints::max_bytes / sizeof(double) / 2;
  Checkpoints checkpoints(10);
  checkpoints.put(0, numbers(half));
  checkpoints.restore(33, numbers(half));
  EXPECT_EQ(checkpoints.steps(), (std::vector<std::int64_t>{0, 33}));
  checkpoints.put(40, numbers(half));
  checkpoints.restore(77, numbers(half));
  EXPECT_EQ(checkpoints.steps(), (std::vector<std::int64_t>{0, 77}));
}

class CheckpointBytes : public testing::Test {
 protected:
  CheckpointBytes() {
    std::int64_t budget = 1000;
    cursor_.advance(500, budget);
    bytes_ = encode_checkpoint(session_, cursor_.simulation());
  }
  /// The bytes with the digest that belongs to them.
  static std::string sealed(std::string bytes) {
    bytes.resize(bytes.size() - sizeof(Bytes32));
    const Bytes32 digest = sha256(bytes);
    return bytes.append(reinterpret_cast<const char*>(digest.data()), digest.size());
  }
  /// Why the bytes are refused; nothing if they are not.
  std::optional<CheckpointFault> fault_of(std::string_view bytes) const {
    const auto result = decode_checkpoint(session_, bytes);
    return result ? std::nullopt : std::optional(result.error().fault);
  }

  Session session_{test::scene()};
  Cursor cursor_{session_, 500};
  std::string bytes_;
};

TEST_F(CheckpointBytes, EveryFlippedByteAndEveryCutIsFound) {
  for (std::size_t i = 0; i < bytes_.size(); ++i) {
    std::string damaged = bytes_;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    ASSERT_EQ(fault_of(damaged), CheckpointFault::corrupt) << "byte " << i;
    ASSERT_EQ(fault_of(bytes_.substr(0, i)), CheckpointFault::corrupt) << "byte " << i;
  }
}

TEST_F(CheckpointBytes, NumbersAreFiniteAndAsManyAsTheStateHas) {
  for (const double number :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    std::string bytes = bytes_;
    std::memcpy(bytes.data() + bytes.size() - sizeof(Bytes32) - sizeof number, &number,
                sizeof number);
    EXPECT_EQ(fault_of(sealed(bytes)), CheckpointFault::corrupt);
  }
  std::string shorter = bytes_;
  shorter.erase(shorter.size() - sizeof(Bytes32) - sizeof(double), sizeof(double));
  EXPECT_EQ(fault_of(sealed(shorter)), CheckpointFault::corrupt);
}

TEST_F(CheckpointBytes, AnotherNumericsIdIsNamed) {
  std::string bytes = bytes_;
  const std::size_t id = 8 + sizeof(std::uint64_t);
  bytes.replace(id, 4, "ffff");
  const auto result = decode_checkpoint(session_, sealed(bytes));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().fault, CheckpointFault::other_numerics);
  EXPECT_EQ(result.error().numerics_id.substr(0, 4), "ffff");
}

TEST_F(CheckpointBytes, AnotherSceneOrFormatIsRefused) {
  const Session other(test::scene({.dimension = 5}));
  const auto result = decode_checkpoint(other, bytes_);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().fault, CheckpointFault::other_scene);
  const std::string bytes = seal_checkpoint(session_, summary_format, {"sa", "ved"});
  EXPECT_EQ(verify_checkpoint(session_, summary_format, bytes), "saved");
  EXPECT_FALSE(verify_checkpoint(session_, state_format, bytes));
}

}  // namespace
}  // namespace stiefel::server
