#pragma once

#include <memory>

#include "stiefel/client/connection.h"

namespace stiefel::client {

/// Whether the server refused a Step because its reply would be too large.
bool is_too_large(const Error& error);

/// What a Step would reply, over a stream, where it may have any size. Throws Error.
v1::StepResponse step_by_stream(std::shared_ptr<const Connection> connection,
                                const v1::StepRequest& request);

}  // namespace stiefel::client
