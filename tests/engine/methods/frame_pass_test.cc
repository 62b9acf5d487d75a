#include <gtest/gtest.h>

#include "engine/frame/frame_pass.h"
#include "tests/support/scenes/random_frame.h"

namespace stiefel {
namespace {

/// State and moments after `steps` passes with arbitrary multipliers.
template <Arithmetic arithmetic, Isa isa>
std::vector<double> after(int steps, int n, int N) {
  const testing::RandomFrame<double> frame(n, N, 7);
  Matrix<double> x(2 * n, N), carry = Matrix<double>::Zero(2 * n, N);
  x << frame.Q, frame.S;
  Vector<double> inverse = Vector<double>::Zero(N + FramePass<double>::width);
  inverse.head(N) = frame.lambda.cwiseInverse();
  const Matrix<double> Y = 0.01 * frame.Q * frame.S.transpose(), Y1 = Y * Y.transpose() - Y;
  FrameMoments<double> moments(n);
  const FrameColumns<double> columns{x.data(), carry.data(), inverse.data(), N};
  const auto pass = make_frame_pass_on<double, isa>(arithmetic, n);
  pass->advance(columns, 0, nullptr, nullptr, moments.sums());
  std::vector<double> all;
  const auto keep = [&](const auto& block) {
    all.insert(all.end(), block.data(), block.data() + block.size());
  };
  for (int k = 0; k < steps; ++k) {
    moments.each(keep);
    pass->advance(columns, 0.1, Y.data(), Y1.data(), moments.sums());
  }
  keep(x);
  keep(carry);
  return all;
}

/// Sizes with and without a path of their own; a last tile that is full, and not; a last pack
/// likewise.
TEST(FramePass, EveryInstructionSetGivesTheSameBits) {
  if (widest_isa() == Isa::baseline) GTEST_SKIP() << "a machine with the baseline alone";
  for (const int n : {1, 2, 3, 4, 5, 9})
    for (const int N : {9, 64, 67, 130}) {
      const auto same = [&]<Arithmetic arithmetic>() {
        const auto baseline = after<arithmetic, Isa::baseline>(3, n, N);
        EXPECT_EQ((after<arithmetic, Isa::avx2>(3, n, N)), baseline) << n << " " << N;
        if (widest_isa() == Isa::avx512) {
          EXPECT_EQ((after<arithmetic, Isa::avx512>(3, n, N)), baseline) << n << " " << N;
        }
      };
      same.template operator()<Arithmetic::compensated>();
      same.template operator()<Arithmetic::plain>();
    }
}

TEST(FramePass, MeasuresTheMoments) {
  for (const int n : {1, 2, 3, 4, 5, 9}) {
    const int N = 67;
    const testing::RandomFrame<double> frame(n, N, 7);
    const Matrix<double> W = frame.lambda.cwiseInverse().asDiagonal();
    const Matrix<double> V = frame.S * W;
    const auto found = after<Arithmetic::plain, Isa::baseline>(1, n, N);
    const double* at = found.data();
    const auto expect = [&](const Matrix<double>& moment) {
      EXPECT_LT((Eigen::Map<const Matrix<double>>(at, n, n) - moment).cwiseAbs().maxCoeff(),
                1e-14 * (1 + moment.norm()));
      at += n * n;
    };
    expect(frame.Q * frame.Q.transpose());
    expect(frame.Q * W * frame.Q.transpose());
    expect(frame.Q * W * W * frame.Q.transpose());
    expect(frame.Q * W * W * W * frame.Q.transpose());
    expect(frame.Q * V.transpose());
    expect(frame.Q * W * V.transpose());
    expect(frame.Q * W * W * V.transpose());
    expect(V * V.transpose());
    expect(V * W * V.transpose());
  }
}

}  // namespace
}  // namespace stiefel
