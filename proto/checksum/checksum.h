#pragma once

#include <cstdint>

#include "stiefel/v1/simulation.pb.h"

namespace stiefel::wire {

/// Returns what the field `checksum` of the message must hold: the CRC-32C of the message's numbers
/// in the order that the .proto file documents at that field. Does not read the field itself.
std::uint32_t checksum(const v1::Sample& sample);
std::uint32_t checksum(const v1::StreamResponse& batch);
std::uint32_t checksum(const v1::DiagnoseResponse& diagnosis);
std::uint32_t checksum(const v1::ConvertResponse& conversion);
std::uint32_t checksum(const v1::ConnectResponse& geodesic);
std::uint32_t checksum(const v1::SummarizeResponse& part);
std::uint32_t checksum(const v1::Session& session);
std::uint32_t checksum(const v1::MeasureTradeoffResponse& part);

/// Returns what `DiagnoseResponse.details_checksum` must hold: the CRC-32C of the numbers that the
/// field `checksum` of that message does not cover.
std::uint32_t details_checksum(const v1::DiagnoseResponse& diagnosis);

}  // namespace stiefel::wire
