#pragma once

namespace stiefel::testing {

/// Over the seeds first, …, first + count − 1 of RandomTop, expects of the method `exact`:
///
///  - in quadruple precision it is the motion: it starts from the start, and its derivative, by
///    differences, is the vector field;
///  - in double, from the same double input, it is the same to an ulp times 1 + the angle turned,
///  and
///    next to the separatrix also to what one ulp of each input changes.
void survey_exact(unsigned first, unsigned count);

}  // namespace stiefel::testing
