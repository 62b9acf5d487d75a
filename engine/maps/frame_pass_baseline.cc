#include "engine/maps/frame_pass_on.h"

namespace stiefel {

template class FramePass<double>;
template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::compensated, Under::S, Isa::baseline>(std::ptrdiff_t);
template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::plain, Under::S, Isa::baseline>(std::ptrdiff_t);
template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::compensated, Under::Qdot, Isa::baseline>(std::ptrdiff_t);
template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::plain, Under::Qdot, Isa::baseline>(std::ptrdiff_t);

}  // namespace stiefel
