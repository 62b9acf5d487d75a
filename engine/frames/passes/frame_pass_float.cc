#include "engine/frames/passes/frame_pass_on.h"

namespace stiefel {

template class FramePass<float>;
template std::unique_ptr<FramePass<float>> make_frame_pass_on<float, Isa::baseline>(Arithmetic,
                                                                                    LowerBlock,
                                                                                    std::ptrdiff_t);

}  // namespace stiefel
