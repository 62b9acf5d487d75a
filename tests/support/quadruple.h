#pragma once

#include "engine/linalg/quadruple.h"

namespace stiefel::testing {

using stiefel::Quad;

}  // namespace stiefel::testing
