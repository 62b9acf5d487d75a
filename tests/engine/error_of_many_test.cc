#include <gtest/gtest.h>

#include "tests/support/error_survey.h"

namespace stiefel {
namespace {

TEST(EstimatedError, OfAThousandScenesIsTheTrueOne) { testing::expect_estimates(10'001, 1000); }

}  // namespace
}  // namespace stiefel
