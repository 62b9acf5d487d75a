#pragma once

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>

#include "server/convert/convert.h"
#include "server/server.h"
#include "stiefel/price.h"
#include "stiefel/simulation.h"
#include "stiefel/v1/common.pb.h"
#include "stiefel/v1/simulation.grpc.pb.h"
#include "tests/server/scene_cases.h"

namespace stiefel::test {

using Stub = v1::SimulationService::Stub;

inline v1::Scene wire_scene(const Case& which = {}) {
  v1::Scene out;
  server::to_proto(description(which), &out);
  return out;
}

/// One server and a stub, without a socket.
struct Harness {
  explicit Harness(server::Options options = {}) : server(std::move(options)) {
    stub = v1::SimulationService::NewStub(server.in_process_channel());
  }

  v1::CreateSessionResponse create(const std::string& id, const v1::Scene& scene,
                                   const std::string& checkpoint = "") {
    v1::CreateSessionRequest request;
    request.set_session_id(id);
    *request.mutable_scene() = scene;
    request.set_checkpoint(checkpoint);
    request.set_return_scene(true);
    grpc::ClientContext context;
    v1::CreateSessionResponse response;
    const auto status = stub->CreateSession(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }

  v1::StepResponse step(const std::string& id, std::int64_t to, bool checkpoint = false) {
    v1::StepRequest request;
    request.set_session_id(id);
    request.set_to(to);
    request.set_return_checkpoint(checkpoint);
    grpc::ClientContext context;
    v1::StepResponse response;
    const auto status = stub->Step(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }

  /// The messages of a stream, and how it ended.
  std::vector<v1::StreamResponse> stream(const v1::StreamRequest& request,
                                         grpc::Status* status = nullptr) {
    grpc::ClientContext context;
    return read_all<v1::StreamResponse>(*stub->Stream(&context, request), status);
  }
  v1::ConvertResponse convert(const v1::ConvertRequest& request) {
    grpc::ClientContext context;
    v1::ConvertResponse response;
    const auto status = stub->Convert(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }
  std::vector<v1::ConnectResponse> connect(const v1::ConnectRequest& request,
                                           grpc::Status* status = nullptr) {
    grpc::ClientContext context;
    return read_all<v1::ConnectResponse>(*stub->Connect(&context, request), status);
  }

  /// Expects OK if nobody asks for the status.
  template <class Response>
  static std::vector<Response> read_all(grpc::ClientReader<Response>& reader,
                                        grpc::Status* status) {
    std::vector<Response> messages(1);
    while (reader.Read(&messages.back())) messages.emplace_back();
    messages.pop_back();
    const grpc::Status end = reader.Finish();
    if (status)
      *status = end;
    else
      EXPECT_TRUE(end.ok()) << end.error_message();
    return messages;
  }

  server::Server server;
  std::unique_ptr<Stub> stub;
};

/// The default fields at a step, as bytes, without any of the server's code.
inline std::string expected_bytes(const Scene& scene, std::int64_t step) {
  const auto simulation = make_simulation(scene);
  simulation->advance(step);
  std::string bytes;
  for (const std::size_t i :
       default_fields(scene, simulation->fields(), simulation->block_count())) {
    std::vector<double> values(static_cast<std::size_t>(simulation->fields()[i].size()));
    simulation->write(i, values);
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  }
  return bytes;
}

inline std::string bytes_of(const v1::Sample& sample) {
  std::string bytes;
  for (const auto& field : sample.fields()) bytes += field.value().data();
  return bytes;
}

}  // namespace stiefel::test
