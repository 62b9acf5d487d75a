#pragma once

#include "engine/linalg/arithmetic/quadruple.h"

namespace stiefel::testing {

using stiefel::Quad;

}  // namespace stiefel::testing
