#pragma once

#include <vector>

#include "stiefel/catalogue.h"

namespace stiefel {

/// The two-forms of a system, and the blocks of which its tangent vectors are made.
std::vector<FormInfo> forms_of(std::string_view system);

}  // namespace stiefel
