// Compares the latency of Step and of Drive to that of a bare echo with messages of the same sizes.
// Arguments: address of the server, address of the echo server, repeats, calls per repeat.
#include <grpcpp/grpcpp.h>

#include <stdexcept>

#include "echo.grpc.pb.h"
#include "stiefel/client/client.h"
#include "tests/bench/measure.h"
#include "tests/bench/wire_scenes.h"

namespace {

using namespace stiefel;
using bench::v1::EchoRequest;
using bench::v1::EchoResponse;

void check(bool ok, const char* what) {
  if (!ok) throw std::runtime_error(what);
}

/// Sets the payload that makes `message` exactly `bytes` long on the wire.
template <class Message>
void pad(Message& message, std::size_t bytes) {
  message.mutable_payload()->resize(bytes);
  while (message.ByteSizeLong() > bytes) message.mutable_payload()->pop_back();
}

EchoRequest echo_request(std::size_t request_bytes, std::size_t reply_bytes) {
  EchoResponse reply;
  pad(reply, reply_bytes);
  EchoRequest request;
  request.set_reply_bytes(static_cast<std::uint32_t>(reply.payload().size()));
  pad(request, request_bytes);
  return request;
}

template <class Call>
double median_microseconds(int calls, Call&& call) {
  std::vector<double> times;
  for (int i = 0; i < calls; ++i) times.push_back(1e6 * bench::seconds(call));
  return bench::median(std::move(times));
}

/// Alternates blocks of our calls and theirs. The first block of each is not counted.
template <class Ours, class Theirs>
void compare(bench::Comparison result, int repeats, int calls, Ours&& ours, Theirs&& theirs) {
  for (int i = 0; i <= repeats; ++i) {
    const double our = median_microseconds(calls, ours);
    const double their = median_microseconds(calls, theirs);
    if (i > 0) result.add(our, their);
  }
  report(result);
}

void unary(const client::Session& session, bench::v1::EchoService::Stub& echo, int repeats,
           int calls) {
  std::int64_t to = 1;
  v1::StepRequest sent;
  sent.set_session_id(session.id());
  sent.set_to(10'000);
  const auto request = echo_request(sent.ByteSizeLong(), session.step(to).ByteSizeLong());
  compare(
      {.name = "Step, p50", .unit = "µs", .rival = "bare unary echo", .bound = 1.25}, repeats,
      calls, [&] { check(session.step(++to).computed_steps() == 1, "not the next step"); },
      [&] {
        grpc::ClientContext context;
        EchoResponse reply;
        check(echo.Echo(&context, request, &reply).ok(), "echo failed");
      });
}

void bidi(const client::Session& session, bench::v1::EchoService::Stub& echo, int repeats,
          int calls) {
  std::int64_t to = 1;
  client::Drive drive = session.drive();
  v1::DriveRequest sent;
  sent.set_session_id(session.id());
  sent.set_to(10'000);
  v1::DriveResponse received;
  *received.mutable_step() = drive.step(to);
  const auto request = echo_request(sent.ByteSizeLong(), received.ByteSizeLong());
  grpc::ClientContext context;
  const auto call = echo.Drive(&context);
  compare(
      {.name = "Drive, p50", .unit = "µs", .rival = "bare bidi echo", .bound = 1.25}, repeats,
      calls, [&] { check(drive.step(++to).computed_steps() == 1, "not the next step"); },
      [&] {
        EchoResponse reply;
        check(call->Write(request) && call->Read(&reply), "echo failed");
      });
  call->WritesDone();
  check(call->Finish().ok(), "echo failed");
}

}  // namespace

int main(int, char** argv) {
  const int repeats = std::stoi(argv[3]), calls = std::stoi(argv[4]);
  const auto client = client::Client::connect(argv[1]);
  const auto echo = bench::v1::EchoService::NewStub(
      grpc::CreateChannel(argv[2], grpc::InsecureChannelCredentials()));
  // Each has its own session, so that every call asks for the session's next step.
  unary(client.temporary(bench::wire_scene(3)), *echo, repeats, calls);
  bidi(client.temporary(bench::wire_scene(3)), *echo, repeats, calls);
}
