#include "engine/frames/passes/rattle_stiefel.h"

#include "engine/frames/passes/frame_pass_on.h"

namespace stiefel {

template class FramePass<double>;
template class FramePass<float>;
template class RattleStiefel<double>;
template class RattleStiefel<float>;
template std::unique_ptr<FramePass<float>> make_frame_pass_on<float, Isa::baseline>(Arithmetic,
                                                                                    LowerBlock,
                                                                                    std::ptrdiff_t);

}  // namespace stiefel
