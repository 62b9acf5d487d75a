// Compares the latency of Step with TLS and a token to the latency without. Arguments: address of
// the open server, address of the closed one, authority, token, repeats, calls per repeat.
#include <stdexcept>

#include "stiefel/client/client.h"
#include "tests/bench/measure.h"
#include "tests/bench/wire_scenes.h"

namespace {

using namespace stiefel;

/// Returns the median time of consecutive calls in microseconds.
double step_microseconds(const client::Session& session, std::int64_t& to, int calls) {
  std::vector<double> times;
  for (int i = 0; i < calls; ++i) {
    times.push_back(1e6 * bench::seconds([&] {
                      if (session.step(++to).computed_steps() != 1)
                        throw std::runtime_error("not the next step");
                    }));
  }
  return bench::median(std::move(times));
}

}  // namespace

int main(int, char** argv) {
  const int repeats = std::stoi(argv[5]), calls = std::stoi(argv[6]);
  client::Options guarded;
  guarded.tls = client::Tls{.ca = argv[3]};
  guarded.token = argv[4];
  const auto open = client::Client::connect(argv[1]),
             closed = client::Client::connect(argv[2], guarded);
  const auto theirs = open.temporary(bench::wire_scene(3)),
             ours = closed.temporary(bench::wire_scene(3));
  std::int64_t at_ours = 0, at_theirs = 0;
  bench::Comparison result{
      .name = "Step with TLS and token, p50", .unit = "µs", .rival = "Step without", .bound = 1.4};
  for (int i = 0; i <= repeats; ++i) {  // the first pair is a warm-up and not counted
    const double our = step_microseconds(ours, at_ours, calls);
    const double their = step_microseconds(theirs, at_theirs, calls);
    if (i > 0) result.add(our, their);
  }
  bench::report(result);
}
