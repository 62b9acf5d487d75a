// Compiled with AVX-512. What stands in here may be named by nobody else, lest the linker take it
// for all machines: everything that is not inlined is a template over Isa::avx512.
#include "engine/maps/frame_pass_on.h"

namespace stiefel {

template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::compensated, Under::S, Isa::avx512>(std::ptrdiff_t);
template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::plain, Under::S, Isa::avx512>(std::ptrdiff_t);
template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::compensated, Under::Qdot, Isa::avx512>(std::ptrdiff_t);
template std::unique_ptr<FramePass<double>>
    make_frame_pass_on<double, Arithmetic::plain, Under::Qdot, Isa::avx512>(std::ptrdiff_t);

}  // namespace stiefel
