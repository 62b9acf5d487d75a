#pragma once

#include <cstdint>

#include "stiefel/v1/simulation.pb.h"

namespace stiefel::wire {

/// The value of the field `checksum` of a message: CRC-32C of its numbers, in the order that the
/// proto documents at that field. The field itself is not read.
std::uint32_t checksum(const v1::Sample& sample);
std::uint32_t checksum(const v1::StreamResponse& batch);
std::uint32_t checksum(const v1::DiagnoseResponse& diagnosis);
std::uint32_t checksum(const v1::ConvertResponse& conversion);
std::uint32_t checksum(const v1::ConnectResponse& geodesic);
std::uint32_t checksum(const v1::SummarizeResponse& part);
std::uint32_t checksum(const v1::Session& session);

}  // namespace stiefel::wire
