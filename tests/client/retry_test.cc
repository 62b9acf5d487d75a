#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>

#include <functional>
#include <thread>

#include "client/cpp/uuid.h"
#include "proto/checksum/checksum.h"
#include "stiefel/client/client.h"
#include "stiefel/v1/error.pb.h"

namespace stiefel::client {
namespace {

const grpc::Status unavailable(grpc::StatusCode::UNAVAILABLE, "out for lunch");

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
  /// Changes a message of `Stream` after its checksum was computed.
  std::function<void(v1::StreamResponse&)> spoil = [](v1::StreamResponse&) {};

  grpc::Status Describe(grpc::ServerContext*, const v1::DescribeRequest*,
                        v1::DescribeResponse* reply) override {
    ++calls;
    if (failures-- > 0) return next_failure ? next_failure(calls) : failure;
    reply->set_version("1");
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
    return messages;
  }

  grpc::Status stream_in_parts(const v1::StreamRequest& request,
                               grpc::ServerWriter<v1::StreamResponse>* writer) {
    int sent = 0;
    const bool breaks = streams_to_break-- > 0;
    for (auto& message : in_parts(request)) {
      if (breaks && sent++ == messages_a_stream) return unavailable;
      if (request.checksum()) message.set_checksum(wire::checksum(message));
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
        response.mutable_step()->mutable_sample()->set_step(request.to());
        response.mutable_step()->mutable_sample()->set_checksum(
            wire::checksum(response.step().sample()));
      }
      stream->Write(response);
    }
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

class RetryTest : public testing::Test {
 protected:
  RetryTest() {
    grpc::ServerBuilder builder;
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    channel_ = server_->InProcessChannel({});
  }

  std::shared_ptr<const Connection> connection(Options options = {}) {
    return std::make_shared<const Connection>(v1::SimulationService::NewStub(channel_), options);
  }

  std::vector<std::int64_t> steps(Range range) {
    client::Stream stream(connection(), "any", std::move(range));
    std::vector<std::int64_t> steps;
    for (const SampleView sample : stream) steps.push_back(sample.step());
    EXPECT_TRUE(stream.run_status());
    return steps;
  }

  Unreliable service_;
  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

TEST_F(RetryTest, ACallIsRepeatedWhileTheServerIsUnavailable) {
  service_.failures = 3;
  EXPECT_EQ(Client(channel_).describe().version(), "1");
  EXPECT_EQ(service_.calls, 4);
}

TEST_F(RetryTest, PatienceEnds) {
  service_.failures = 1'000'000;
  Options options;
  options.patience = std::chrono::milliseconds(60);
  const Client client(channel_, options);
  EXPECT_THROW(client.describe(), Error);
  EXPECT_EQ(service_.calls, 3);  // at 0, 25 and 75 ms
}

TEST_F(RetryTest, AServerThatComesLateIsFound) {
  const std::string address = "unix:" + testing::TempDir() + "stiefel_" + make_uuid();
  Options options;
  options.patience = std::chrono::milliseconds(0);
  EXPECT_THROW(Client::connect(address, options).describe(), Error);

  std::unique_ptr<grpc::Server> server;
  const std::jthread late([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    grpc::ServerBuilder builder;
    builder.AddListeningPort(address, grpc::InsecureServerCredentials());
    builder.RegisterService(&service_);
    server = builder.BuildAndStart();
  });
  options.patience = std::chrono::minutes(1);
  EXPECT_EQ(Client::connect(address, options).describe().version(), "1");
}

TEST_F(RetryTest, AWrongRequestIsNotRepeated) {
  service_.failures = 1;
  service_.failure = {grpc::StatusCode::INVALID_ARGUMENT, "no"};
  EXPECT_THROW(Client(channel_).describe(), Error);
  EXPECT_EQ(service_.calls, 1);
}

/// RESOURCE_EXHAUSTED, to be tried again after that time; of 0 ms: without a time.
grpc::Status refusal(std::chrono::milliseconds delay) {
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

TEST_F(RetryTest, ARefusalWithATimeIsRepeatedAfterIt) {
  service_.failures = 3;
  service_.failure = refusal(std::chrono::milliseconds(20));
  Options options;
  options.patience = std::chrono::milliseconds(0);  // of a server that is not there
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(Client(channel_, options).describe().version(), "1");
  EXPECT_EQ(service_.calls, 4);
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(60));
}

TEST_F(RetryTest, ARefusalWithoutATimeIsNotRepeated) {
  service_.failures = 1;
  service_.failure = refusal(std::chrono::milliseconds(0));
  EXPECT_THROW(Client(channel_).describe(), Error);
  EXPECT_EQ(service_.calls, 1);
}

TEST_F(RetryTest, ARefusalUntilAfterTheDeadlineIsToldAtOnce) {
  service_.failures = 1;
  service_.failure = refusal(std::chrono::hours(1));
  const auto start = std::chrono::steady_clock::now();
  try {
    Client(channel_).describe();
    ADD_FAILURE() << "no Error was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << error.what();
    EXPECT_EQ(error.retry_delay(), std::chrono::hours(1));
  }
  EXPECT_EQ(service_.calls, 1);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST_F(RetryTest, AStreamThatIsRefusedBegins) {
  service_.failures = 2;
  service_.failure = refusal(std::chrono::milliseconds(1));
  EXPECT_THAT(steps({3, 5, 1}), testing::ElementsAre(3, 4, 5));
  EXPECT_EQ(service_.calls, 3);
}

TEST_F(RetryTest, AttemptsForBothReasonsAddUp) {
  service_.failures = 1'000'000;
  int refused = 0;
  service_.next_failure = [&](int call) {
    if (call % 2) return unavailable;
    ++refused;
    return refusal(std::chrono::milliseconds(1));
  };
  Options options;
  options.patience = std::chrono::milliseconds(60);
  EXPECT_THROW(Client(channel_, options).describe(), Error);
  EXPECT_EQ(service_.calls, 5) << "two pauses of patience, and a refusal before each and the end";
  EXPECT_EQ(refused, 2);
}

TEST_F(RetryTest, ARefusedRequestOfADriveIsRepeatedOnIt) {
  service_.failures = 3;
  service_.failure = refusal(std::chrono::milliseconds(1));
  v1::Session description;
  description.set_session_id("any");
  const Session session(connection(), description, {}, true);
  Drive drive = session.drive();
  EXPECT_EQ(drive.step(7).sample().step(), 7);
  EXPECT_EQ(service_.calls, 4);
  service_.failures = 1;
  service_.failure = refusal(std::chrono::milliseconds(0));
  EXPECT_THROW(drive.step(8), Error);
  EXPECT_EQ(drive.step(9).sample().step(), 9) << "the drive lives";
}

TEST(RefusalsTest, AreBounded) {
  Refusals refusals;
  const grpc::Status status = refusal(std::chrono::milliseconds(5));
  for (int i = 0; i < Refusals::most; ++i) {
    const auto pause = refusals.next(status);
    ASSERT_TRUE(pause);
    EXPECT_GE(*pause, std::chrono::milliseconds(5));
    EXPECT_LE(*pause, std::chrono::milliseconds(5 + std::min(10 << std::min(i, 7), 1000)));
  }
  EXPECT_FALSE(refusals.next(status));
  EXPECT_FALSE(Refusals().next(unavailable));
}

TEST_F(RetryTest, ABrokenStreamGoesOnWhereItBroke) {
  for (const Range& range : {Range{0, 9, 1}, Range{2, 11, 4}, Range{0, 10, 3}, Range{5, 5, 1}}) {
    service_.streams_to_break = 0;
    const auto whole = steps(range);
    service_.streams_to_break = 1'000'000;
    for (const int messages : {1, 2, 3}) {
      service_.messages_a_stream = messages;
      // Every stream breaks after so many messages; the one that only lacks its run status must not
      // break for ever.
      service_.streams_to_break = static_cast<int>(whole.size() / 2 + 1);
      EXPECT_EQ(steps(range), whole) << range.from << ' ' << range.to << ' ' << range.every;
    }
  }
}

TEST_F(RetryTest, TheStepsOfEveryStreamAreCounted) {
  service_.messages_a_stream = 1;  // two samples: 0 and 1, 2 and 3, 4 and 5, and the rest at once
  service_.streams_to_break = 3;
  Stream stream(connection(), "any", {0, 9, 1});
  while (stream.next_batch()) {
  }
  EXPECT_EQ(service_.calls, 4);
  EXPECT_EQ(stream.computed_steps(), 1 + 1 + 1 + 3);
}

TEST_F(RetryTest, TheDeadlineIsThatOfAllStreamsTogether) {
  service_.messages_a_stream = 1;
  service_.pause_a_message = std::chrono::milliseconds(30);
  Options options;
  options.compute_timeout = std::chrono::milliseconds(300);
  const auto start = std::chrono::steady_clock::now();
  Stream stream(connection(options), "any", {0, 1'000'000, 1});
  int batches = 0;
  try {
    while (stream.next_batch()) ++batches;
    ADD_FAILURE() << "no Error was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::StatusCode::DEADLINE_EXCEEDED) << error.what();
  }
  EXPECT_GE(batches, 1);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST_F(RetryTest, APauseEndsWithTheDeadline) {
  service_.failures = 1'000'000;
  Options options;
  options.timeout = std::chrono::milliseconds(100);
  options.patience = std::chrono::hours(1);
  try {
    Client(channel_, options).describe();
    ADD_FAILURE() << "no Error was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::StatusCode::DEADLINE_EXCEEDED) << error.what();
  }
}

TEST_F(RetryTest, AStreamThatNeverBeganIsRepeated) {
  service_.failures = 2;
  EXPECT_THAT(steps({3, 5, 1}), testing::ElementsAre(3, 4, 5));
}

TEST_F(RetryTest, ASampleInPartsIsSentAgainWhenItsStreamBreaks) {
  for (const int messages : {1, 2, 3, 4, 5, 6, 7}) {
    service_.messages_a_stream = messages;
    service_.streams_to_break = messages < 3 ? 1 : 2;
    Stream stream(connection(), "any", {.from = 3, .to = 5, .fields = {"large"}});
    std::vector<std::int64_t> steps;
    for (const SampleView sample : stream) {
      steps.push_back(sample.step());
      const auto numbers = sample.field("large").values;
      ASSERT_EQ(numbers.size(), 5u);
      for (std::size_t i = 0; i < 5; ++i)
        EXPECT_EQ(numbers[i], static_cast<double>(sample.step()) + static_cast<double>(i));
    }
    EXPECT_THAT(steps, testing::ElementsAre(3, 4, 5)) << messages;
    EXPECT_TRUE(stream.run_status());
  }
}

TEST_F(RetryTest, AStateTooLargeForAReplyComesOverAStream) {
  v1::Session description;
  description.set_session_id("any");
  for (const int messages : {3, 4, 5, 100}) {
    service_.messages_a_stream = messages;
    service_.streams_to_break = 1;
    const Session session(connection(), description, {}, true);
    const auto reply = session.step(4, {"large"});
    EXPECT_EQ(reply.sample().step(), 4);
    EXPECT_EQ(field(reply.sample(), "large").values[4], 8);
    EXPECT_EQ(reply.run_status().outcome(), v1::OUTCOME_REACHED);
    EXPECT_EQ(reply.sample().fields(0).value().shape_size(), 2);
  }
}

TEST_F(RetryTest, ACheckpointInPartsIsPutTogether) {
  for (const int messages : {3, 4, 5, 100}) {
    service_.messages_a_stream = messages;
    service_.streams_to_break = 1;
    Stream stream(connection(), "any",
                  {.from = 4, .to = 4, .fields = {"large"}, .return_checkpoint = true});
    while (stream.next_batch() != nullptr) {
    }
    ASSERT_TRUE(stream.checkpoint()) << messages;
    EXPECT_EQ(stream.checkpoint()->step, 4);
    EXPECT_EQ(stream.checkpoint()->bytes, "a checkpoint");
  }
}

TEST_F(RetryTest, NumbersThatChangeOnTheirWayAreNoticed) {
  service_.streams_to_break = 0;
  const auto run = [&](bool checksums) {
    Stream stream(connection({.checksums = checksums}), "any",
                  {.from = 4, .to = 4, .fields = {"large"}, .return_checkpoint = true});
    while (stream.next_batch() != nullptr) {
    }
  };
  EXPECT_NO_THROW(run(true));
  const std::vector<std::function<void(v1::StreamResponse&)>> spoils = {
      [](auto& message) {
        if (message.fields_size() > 0)
          (*message.mutable_fields(0)->mutable_value()->mutable_data())[3] ^= 1;
      },
      [](auto& message) {
        if (message.times_size() > 0) message.set_times(0, 0.5);
      },
      [](auto& message) {
        if (message.has_checkpoint()) (*message.mutable_checkpoint()->mutable_data())[0] ^= 1;
      }};
  for (const auto& spoil : spoils) {
    service_.spoil = spoil;
    EXPECT_THROW(run(true), CorruptReply);
    EXPECT_NO_THROW(run(false));
  }
}

}  // namespace
}  // namespace stiefel::client
