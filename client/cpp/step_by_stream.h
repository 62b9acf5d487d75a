#pragma once

#include <memory>

#include "stiefel/client/connection.h"

namespace stiefel::client {

/// Returns whether the server refused a Step because its reply would be too large.
bool is_too_large(const Error& error);

/// Returns the reply of a Step, fetched over a stream, which has no size limit. Throws Error.
v1::StepResponse step_by_stream(std::shared_ptr<const Connection> connection,
                                const v1::StepRequest& request,
                                std::shared_ptr<Recreation> recreation);

}  // namespace stiefel::client
