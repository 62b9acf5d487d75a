#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "engine/frame/frame_pass.h"
#include "engine/numbers/parallel.h"

namespace stiefel {

/// The passes over the columns of a state in at most 64 blocks, which the threads of the crew
/// share. The moments are summed within each block, then over the blocks in their order. N alone
/// decides the blocks, so the bits are the same on any number of threads; up to `least_columns`
/// columns there is one block.
template <class Scalar>
class BlockedPass {
 public:
  /// A block has at least so many columns, and at least 64 for each row: its own sums and tiles
  /// then take less than a seventh of the memory of its columns.
  static constexpr std::ptrdiff_t least_columns = 4096, most_blocks = 64;

  BlockedPass(Arithmetic arithmetic, std::ptrdiff_t n, std::ptrdiff_t N)
      : size_(block_size(n, N)), nanoseconds_(static_cast<double>(n * n + n) / 2) {
    const std::ptrdiff_t blocks = std::max<std::ptrdiff_t>(1, (N + size_ - 1) / size_);
    blocks_.reserve(static_cast<std::size_t>(blocks));
    for (std::ptrdiff_t k = 0; k < blocks; ++k)
      blocks_.push_back(
          {make_frame_pass<Scalar>(arithmetic, n), FrameMoments<Scalar>(blocks > 1 ? n : 0)});
  }

  void advance(const FrameColumns<Scalar>& x, Scalar h, const Scalar* Y_h, const Scalar* Y1_h,
               FrameMoments<Scalar>& moments) {
    if (blocks_.size() == 1) return blocks_[0].pass->advance(x, h, Y_h, Y1_h, moments.sums());
    const std::ptrdiff_t height = 2 * moments.QQ[0].rows();
    const double all = nanoseconds_ * static_cast<double>(x.count);
    for_each_in_parallel(std::span(blocks_), all, [&](Block& block) {
      const std::ptrdiff_t first = (&block - blocks_.data()) * size_;
      block.pass->advance({x.value + first * height, x.carry ? x.carry + first * height : nullptr,
                           x.inverse + first, std::min(size_, x.count - first)},
                          h, Y_h, Y1_h, block.moments.sums());
    });
    moments = blocks_[0].moments;
    for (std::size_t k = 1; k < blocks_.size(); ++k) moments += blocks_[k].moments;
  }

 private:
  struct Block {
    std::unique_ptr<FramePass<Scalar>> pass;
    FrameMoments<Scalar> moments;  ///< empty if there is one block
  };

  static std::ptrdiff_t block_size(std::ptrdiff_t n, std::ptrdiff_t N) {
    constexpr std::ptrdiff_t unit = FramePass<Scalar>::width;
    const std::ptrdiff_t least =
        std::max({least_columns, unit * n, (N + most_blocks - 1) / most_blocks});
    return (least + unit - 1) / unit * unit;
  }

  std::ptrdiff_t size_;
  double nanoseconds_;  ///< a rough time of one column
  std::vector<Block> blocks_;
};

}  // namespace stiefel
