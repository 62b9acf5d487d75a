// Views of tensors and of samples.
#include "stiefel/client/samples.h"

#include <gmock/gmock.h>

#include "tests/client/error_of.h"

namespace stiefel::client {
namespace {

using testing::ElementsAre;

/// Numbers 0, 1, ... of a tensor of that shape.
template <class Number = double>
v1::Tensor counting(const std::vector<std::uint64_t>& shape,
                    v1::DataType type = v1::DATA_TYPE_FLOAT64) {
  std::size_t size = 1;
  for (const std::uint64_t extent : shape) size *= extent;
  std::vector<Number> numbers;
  for (std::size_t i = 0; i < size; ++i)
    numbers.push_back(static_cast<Number>(static_cast<double>(i)));
  v1::Tensor tensor;
  tensor.mutable_shape()->Add(shape.begin(), shape.end());
  tensor.set_data_type(type);
  tensor.set_data(reinterpret_cast<const char*>(numbers.data()), size * sizeof(Number));
  return tensor;
}

TEST(Matrix, IsAViewOfTheNumbersRowByRow) {
  const v1::Tensor tensor = counting({4, 2, 3});
  const auto third = matrix(tensor, 2);
  EXPECT_EQ(third, (Eigen::Matrix<double, 2, 3>{{12, 13, 14}, {15, 16, 17}}));
  EXPECT_EQ(reinterpret_cast<const char*>(third.data()), tensor.data().data() + 12 * 8);
  EXPECT_EQ(matrix(counting({3})), (Eigen::RowVector3d{0, 1, 2}));
  EXPECT_EQ(matrix(counting({2, 0})).size(), 0);
}

TEST(Matrix, HasTheNumbersOfTheTensor) {
  EXPECT_EQ(matrix<float>(counting<float>({2, 2}, v1::DATA_TYPE_FLOAT32))(1, 0), 2.f);
  EXPECT_EQ(matrix<std::int64_t>(counting<std::int64_t>({2, 2}, v1::DATA_TYPE_INT64))(1, 1), 3);
  const v1::Tensor tensor = counting<std::complex<double>>({1, 3}, v1::DATA_TYPE_COMPLEX128);
  EXPECT_EQ(matrix<std::complex<double>>(tensor)(0, 2), std::complex<double>(2));
  EXPECT_THROW(matrix<double>(tensor), std::invalid_argument);
}

TEST(Matrix, HasTheShapeOfTheTensorOrThrows) {
  EXPECT_THROW(matrix(counting({4, 2, 3}), 4), std::out_of_range);
  v1::Tensor tensor = counting({2, 3});
  tensor.mutable_data()->pop_back();
  EXPECT_EQ(error_of([&] { matrix(tensor); }).code(), grpc::StatusCode::DATA_LOSS);
  tensor = counting({2, 3});
  tensor.set_shape(0, std::uint64_t{1} << 62);
  EXPECT_EQ(error_of([&] { matrix(tensor); }).code(), grpc::StatusCode::DATA_LOSS);
}

TEST(SampleTest, FindsStepMemberAndField) {
  v1::StreamResponse batch;
  for (const std::int64_t step : {5, 7}) batch.add_steps(step);
  for (const double time : {0.5, 0.7}) batch.add_times(time);
  batch.add_fields()->set_name("Q");
  *batch.mutable_fields(0)->mutable_value() = counting({2, 3, 1, 2});  // of three members
  const Sample sample(batch, 1);
  EXPECT_EQ(sample.step(), 7);
  EXPECT_EQ(sample.time(), 0.7);
  EXPECT_THAT(sample.fields(), ElementsAre("Q"));
  EXPECT_EQ(sample.field("Q", 2), (Eigen::RowVector2d{10, 11}));
  EXPECT_THROW(sample.field("Q", 3), std::out_of_range) << "that is of the next sample";
  EXPECT_THROW(sample.field("M"), std::out_of_range);
  EXPECT_THROW(sample.field<float>("Q"), std::invalid_argument);

  v1::Sample alone;
  alone.add_fields()->set_name("Q");
  *alone.mutable_fields(0)->mutable_value() = counting({3, 1, 2});
  EXPECT_EQ(Sample(alone).field("Q", 1), (Eigen::RowVector2d{2, 3}));
}

}  // namespace
}  // namespace stiefel::client
