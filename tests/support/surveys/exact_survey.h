#pragma once

namespace stiefel::testing {

/// Expects of the method `exact`, for the seeds first, …, first + count − 1 of RandomTop:
///
///  - in quadruple precision it solves the equations: at time 0 it is the initial state, and its
///    derivative, computed by differences, is the vector field;
///  - in double, from the same input, it agrees with quadruple precision to one ulp times (1 + the
///    angle turned) and, near the separatrix, to the change that one ulp of each input makes.
void survey_exact(unsigned first, unsigned count);

}  // namespace stiefel::testing
