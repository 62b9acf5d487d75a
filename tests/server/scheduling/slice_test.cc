#include "server/scheduling/slice.h"

#include <gtest/gtest.h>

namespace stiefel::server {
namespace {

TEST(Slices, AreNumbersOfSteps) {
  EXPECT_EQ(slice_steps(200), 10'000);
  EXPECT_EQ(slice_steps(2e6), 1);
  EXPECT_EQ(slice_steps(1e12), 1) << "a slice is never empty";
  EXPECT_EQ(slice_steps(0), 2'000'000) << "a cost of nothing is not believed";
  {
    const SliceLength length(brief_slice_nanoseconds);
    EXPECT_EQ(slice_steps(200), 1000);
    {
      const SliceLength inner(slice_nanoseconds / 2);
      EXPECT_EQ(slice_steps(200), 5000);
    }
    EXPECT_EQ(slice_steps(200), 1000);
  }
  EXPECT_EQ(slice_steps(200), 10'000);
}

TEST(Slices, StepsSayTheirKind) {
  EXPECT_EQ(kind_of_steps(1), JobKind::brief);
  EXPECT_EQ(kind_of_steps(brief_slice_nanoseconds), JobKind::brief);
  EXPECT_EQ(kind_of_steps(slice_nanoseconds), JobKind::sliced);
  EXPECT_EQ(kind_of_steps(1.1 * slice_nanoseconds), JobKind::unsliced);
}

}  // namespace
}  // namespace stiefel::server
