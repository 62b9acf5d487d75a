#pragma once

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "stiefel/client/client.h"
#include "stiefel/v1/error.pb.h"

namespace stiefel::client {

inline const grpc::Status unavailable(grpc::StatusCode::UNAVAILABLE, "out for lunch");

/// RESOURCE_EXHAUSTED, to be tried again after that time; of 0 ms: without a time.
inline grpc::Status refusal(std::chrono::milliseconds delay) {
  v1::Status status;
  status.set_code(grpc::StatusCode::RESOURCE_EXHAUSTED);
  if (delay.count() > 0) {
    v1::RetryInfo retry;
    retry.mutable_retry_delay()->set_seconds(delay.count() / 1000);
    retry.mutable_retry_delay()->set_nanos(static_cast<int>(delay.count() % 1000) * 1'000'000);
    auto& any = *status.add_details();
    any.set_type_url("type.googleapis.com/google.rpc.RetryInfo");
    any.set_value(retry.SerializeAsString());
  }
  return {grpc::StatusCode::RESOURCE_EXHAUSTED, "no place", status.SerializeAsString()};
}

/// A price, which a message of a stream must have first.
inline v1::Price a_price() {
  v1::Price price;
  price.set_bound(v1::PRICE_BOUND_EXPECTED);
  return price;
}

/// The field x of states whose number is their step, as many samples as there are steps.
template <class Numbers>
v1::Field field_x(const Numbers& steps, bool batched) {
  v1::Field field;
  field.set_name("x");
  auto& tensor = *field.mutable_value();
  tensor.set_data_type(v1::DATA_TYPE_FLOAT64);
  if (batched) tensor.add_shape(static_cast<std::uint64_t>(steps.size()));
  for (int axis = 0; axis < 2; ++axis) tensor.add_shape(1);
  for (const auto step : steps) {
    const auto number = static_cast<double>(step);
    tensor.mutable_data()->append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  return field;
}

/// Fails a given number of times, and breaks every stream after a given number of messages.
class Unreliable : public v1::SimulationService::Service {
 public:
  int failures = 0;
  grpc::Status failure = unavailable;
  /// Of the call with that number, from 1; `failure` without it.
  std::function<grpc::Status(int)> next_failure;
  int messages_a_stream = 1'000'000;
  int streams_to_break = 1'000'000;
  int calls = 0;
  std::chrono::milliseconds pause_a_message{0};
  /// Changes a message of `Stream`.
  std::function<void(v1::StreamResponse&)> spoil = [](v1::StreamResponse&) {};

  grpc::Status Describe(grpc::ServerContext*, const v1::DescribeRequest*,
                        v1::DescribeResponse* reply) override {
    ++calls;
    if (failures-- > 0) return next_failure ? next_failure(calls) : failure;
    reply->set_version("1");
    reply->set_numerics_id("2");
    reply->set_build("3");
    reply->mutable_limits();
    reply->add_systems();
    reply->add_methods();
    return grpc::Status::OK;
  }

  /// The field "large" of a step has the numbers step, step + 1, ..., step + 4.
  static std::vector<v1::StreamResponse> in_parts(const v1::StreamRequest& request) {
    std::vector<v1::StreamResponse> messages;
    for (std::int64_t step = request.from(); step <= request.to(); step += request.every()) {
      for (const int offset : {0, 2, 4}) {
        v1::StreamResponse message;
        message.add_steps(step);
        message.add_times(static_cast<double>(step));
        auto& field = *message.add_fields();
        field.set_name("large");
        for (const int extent : {1, 1, 5})
          field.add_whole_shape(static_cast<std::uint64_t>(extent));
        field.set_offset(static_cast<std::uint64_t>(offset));
        std::vector<double> numbers;
        for (int i = offset; i < std::min(offset + 2, 5); ++i)
          numbers.push_back(static_cast<double>(step + i));
        field.mutable_value()->add_shape(numbers.size());
        field.mutable_value()->set_data_type(v1::DATA_TYPE_FLOAT64);
        field.mutable_value()->set_data(reinterpret_cast<const char*>(numbers.data()),
                                        numbers.size() * sizeof(double));
        message.set_sample_continues(offset < 4);
        messages.push_back(message);
      }
    }
    const std::string checkpoint = "a checkpoint";
    for (std::size_t offset = 0; request.return_checkpoint() && offset < checkpoint.size();
         offset += 5) {
      auto& part = *messages.emplace_back().mutable_checkpoint();
      part.set_step(request.to());
      part.set_size(checkpoint.size());
      part.set_offset(offset);
      part.set_data(checkpoint.substr(offset, 5));
    }
    messages.emplace_back().mutable_run_status()->set_outcome(v1::OUTCOME_REACHED);
    *messages.front().mutable_price() = a_price();
    return messages;
  }

  grpc::Status stream_in_parts(const v1::StreamRequest& request,
                               grpc::ServerWriter<v1::StreamResponse>* writer) {
    int sent = 0;
    const bool breaks = streams_to_break-- > 0;
    for (auto& message : in_parts(request)) {
      if (breaks && sent++ == messages_a_stream) return unavailable;
      spoil(message);
      writer->Write(message);
    }
    return grpc::Status::OK;
  }

  grpc::Status Step(grpc::ServerContext*, const v1::StepRequest*, v1::StepResponse*) override {
    ++calls;
    v1::ErrorInfo info;
    info.set_reason("REPLY_TOO_LARGE");
    v1::Status status;
    auto& any = *status.add_details();
    any.set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
    any.set_value(info.SerializeAsString());
    return {grpc::StatusCode::INVALID_ARGUMENT, "too large", status.SerializeAsString()};
  }

  /// The step asked for, or the failure in the reply.
  grpc::Status Drive(
      grpc::ServerContext*,
      grpc::ServerReaderWriter<v1::DriveResponse, v1::DriveRequest>* stream) override {
    for (v1::DriveRequest request; stream->Read(&request);) {
      ++calls;
      v1::DriveResponse response;
      if (failures-- > 0) {
        response.mutable_error()->ParseFromString(failure.error_details());
        response.mutable_error()->set_message(failure.error_message());
      } else {
        v1::StepResponse& step = *response.mutable_step();
        step.mutable_run_status()->set_outcome(v1::OUTCOME_REACHED);
        *step.mutable_price() = a_price();
        step.mutable_sample()->set_step(request.to());
        *step.mutable_sample()->add_fields() = field_x(std::array{request.to()}, false);
      }
      stream->Write(response);
    }
    return grpc::Status::OK;
  }

  /// A setup, then an empty front.
  grpc::Status MeasureTradeoff(grpc::ServerContext*, const v1::MeasureTradeoffRequest*,
                               grpc::ServerWriter<v1::MeasureTradeoffResponse>* writer) override {
    v1::MeasureTradeoffResponse part;
    part.mutable_setup()->set_horizon(2);
    part.mutable_setup()->set_machine("a machine");
    part.mutable_setup()->set_numerics_id("2");
    part.mutable_setup()->set_reference("a reference");
    *part.mutable_setup()->mutable_price() = a_price();
    writer->Write(part);
    part.mutable_front();
    writer->Write(part);
    return grpc::Status::OK;
  }

  /// Two samples a message, then a message with the run status alone.
  grpc::Status Stream(grpc::ServerContext*, const v1::StreamRequest* request,
                      grpc::ServerWriter<v1::StreamResponse>* writer) override {
    ++calls;
    if (failures-- > 0) return failure;
    if (request->fields_size() == 1) return stream_in_parts(*request, writer);
    const bool breaks = streams_to_break-- > 0;
    int sent = 0;
    v1::StreamResponse message;
    for (std::int64_t step = request->from();;) {
      message.add_steps(step);
      message.add_times(static_cast<double>(step));
      const bool last = step == request->to();
      if (last || message.steps_size() == 2) {
        if (breaks && sent == messages_a_stream) return unavailable;
        std::this_thread::sleep_for(pause_a_message);
        message.set_computed_steps(step - request->from());
        *message.add_fields() = field_x(message.steps(), true);
        if (sent == 0) *message.mutable_price() = a_price();
        writer->Write(message);
        message.Clear();
        ++sent;
      }
      if (last) break;
      step = std::min(step + request->every(), request->to());
    }
    if (breaks && sent == messages_a_stream) return unavailable;
    message.set_computed_steps(request->to() - request->from());
    message.mutable_run_status()->set_outcome(v1::OUTCOME_REACHED);
    writer->Write(message);
    return grpc::Status::OK;
  }
};

/// Clients of that service, without a socket.
class UnreliableTest : public testing::Test {
 protected:
  UnreliableTest() {
    grpc::ServerBuilder builder;
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    channel_ = server_->InProcessChannel({});
  }

  std::shared_ptr<const Connection> connection(Options options = {}) {
    return std::make_shared<const Connection>(v1::SimulationService::NewStub(channel_), options);
  }

  Unreliable service_;
  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace stiefel::client
