#include <gtest/gtest.h>

#include <Eigen/Core>

namespace stiefel {
namespace {

// Eigen splits the sums of a product where a panel of the factors fills the first cache: with 32
// KiB after 504 numbers, with 48 KiB after 760. States have the same bits on both kinds of
// processor only if the sizes are fixed.
TEST(ProductBlocking, DoesNotDependOnTheProcessorsCaches) {
  EXPECT_EQ(Eigen::l1CacheSize(), 32 << 10);
  EXPECT_EQ(Eigen::l2CacheSize(), 256 << 10);
  EXPECT_EQ(Eigen::l3CacheSize(), 2 << 20);
}

}  // namespace
}  // namespace stiefel
