#include "engine/bracket/taylor_double_bracket.h"

#include "engine/accuracy/taylor_reference.h"

namespace stiefel {

template class TaylorDoubleBracket<long double>;
template class TaylorMotion<TaylorDoubleBracket<long double>>;

constinit const SeriesEquations double_bracket_equations = {
    [](const SeriesStart<long double>& start, const ReferenceNeed& need) {
      const auto make = [&](int order) {
        return TaylorDoubleBracket<long double>(start.lambda, start.lambda_v, order);
      };
      return taylor_reference(make, start, need);
    }};

}  // namespace stiefel
