#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "stiefel/scene.h"

/// M (3 × 3) of a rigid body at step `to`, computed by a server that runs as long as this call.
/// `program` is stiefel-server. Throws stiefel::client::Error.
Eigen::MatrixXd remote_momentum(const std::string& program,
                                const stiefel::SceneDescription& description, std::int64_t to);
