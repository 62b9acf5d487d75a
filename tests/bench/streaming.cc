// Compares the time to stream samples of N = 3 (Q and M at every step) into the C++ client to that
// of a bare stream of the same bytes plus an embedded Simulation that writes the same samples into
// a buffer. Arguments: address of the server, address of the echo server, repeats, samples.
#include <grpcpp/grpcpp.h>

#include <stdexcept>

#include "echo.grpc.pb.h"
#include "stiefel/client/client.h"
#include "stiefel/simulation.h"
#include "tests/bench/measure.h"
#include "tests/bench/wire_scenes.h"

namespace {

using namespace stiefel;

struct Volume {
  std::int64_t samples = 0;
  std::uint64_t messages = 0, bytes = 0;
};

void check(bool ok, const char* what) {
  if (!ok) throw std::runtime_error(what);
}

Volume streamed(const client::Session& session, std::int64_t samples, bool count_bytes) {
  Volume volume;
  auto stream = session.stream({.from = 0, .to = samples - 1});
  while (const auto* batch = stream.next_batch()) {
    volume.samples += batch->steps_size();
    ++volume.messages;
    if (count_bytes) volume.bytes += batch->ByteSizeLong();
  }
  check(volume.samples == samples, "samples are missing");
  return volume;
}

void poured(bench::v1::EchoService::Stub& echo, const Volume& volume) {
  bench::v1::PourRequest request;
  request.set_message_bytes(static_cast<std::uint32_t>(volume.bytes / volume.messages));
  request.set_messages(volume.messages);
  grpc::ClientContext context;
  const auto call = echo.Pour(&context, request);
  bench::v1::EchoResponse message;
  std::uint64_t bytes = 0;
  while (call->Read(&message)) bytes += message.payload().size();
  check(call->Finish().ok(), "the bare stream failed");
  check(bytes == request.message_bytes() * request.messages(), "bytes are missing");
}

/// Writes Q and M at every step into `buffer`, sample after sample.
void embedded(Simulation& simulation, std::int64_t samples, std::vector<double>& buffer) {
  double* out = buffer.data();
  for (std::int64_t k = 0; k < samples; ++k) {
    if (k > 0) check(simulation.advance(1).reached(), "the simulation stopped");
    for (std::size_t field = 0; field < 2; ++field, out += 9) simulation.write(field, {out, 9});
  }
}

}  // namespace

int main(int, char** argv) {
  const int repeats = std::stoi(argv[3]);
  const std::int64_t samples = std::stoll(argv[4]);
  const auto client = client::Client::connect(argv[1]);
  const auto echo = bench::v1::EchoService::NewStub(
      grpc::CreateChannel(argv[2], grpc::InsecureChannelCredentials()));
  const v1::Scene scene = bench::wire_scene(3);
  std::vector<double> buffer(static_cast<std::size_t>(18 * samples));

  const Volume volume = streamed(client.temporary(scene), samples, true);
  bench::Comparison result{.name = "Stream, " + std::to_string(samples) + " samples, C++ client",
                           .unit = "s",
                           .rival = "bare stream + embedded Simulation",
                           .bound = 1.25};
  bench::Figure bare{.name = "of which bare stream", .unit = "s"};
  bench::Figure engine{.name = "of which embedded Simulation", .unit = "s"};
  for (int i = 0; i <= repeats; ++i) {
    const client::Session session = client.temporary(scene);
    const double ours = bench::seconds([&] { streamed(session, samples, false); });
    const double pour = bench::seconds([&] { poured(*echo, volume); });
    const auto simulation =
        make_simulation(testing::random_scene(3, 1, bench::h_omega, "variational"));
    const double compute = bench::seconds([&] { embedded(*simulation, samples, buffer); });
    if (i == 0) continue;
    result.add(ours, pour + compute);
    bare.values.push_back(pour);
    engine.values.push_back(compute);
  }
  report(result);
  report(bare);
  report(engine);
  report(bench::Figure{.name = "Bytes of those samples",
                       .unit = "MB",
                       .values = {1e-6 * static_cast<double>(volume.bytes)}});
  report(bench::Figure{.name = "Messages they came in",
                       .unit = "",
                       .values = {static_cast<double>(volume.messages)}});
}
