// Joins pairs of frames in one Connect on a server of two threads, and compares the rate to that of
// two servers of one thread each that join half of them at the same time. Arguments: addresses of
// the server of two threads and of the two others, repeats, pairs.
#include <future>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/frame/geodesics/geodesic_series.h"
#include "stiefel/client/client.h"
#include "tests/bench/measure.h"
#include "tests/support/scenes/two_frames.h"

namespace {

using namespace stiefel;

void write(const Eigen::MatrixXd& frame, v1::Matrix& out) {
  out.set_rows(static_cast<std::uint32_t>(frame.rows()));
  out.set_cols(static_cast<std::uint32_t>(frame.cols()));
  for (Eigen::Index i = 0; i < frame.rows(); ++i)
    for (Eigen::Index j = 0; j < frame.cols(); ++j) out.add_values(frame(i, j));
}

/// Returns a request to join `pairs` random frames to the ends of geodesics of length π/2 in ‖Q̇‖_F,
/// with one Λ over 1 : 10.
v1::ConnectRequest request(int n, int N, int pairs) {
  constexpr double spread = 10;
  const Eigen::VectorXd inertia = testing::random_frames(n, N, spread, 1).inertia;
  v1::ConnectRequest out;
  for (const double l : inertia) out.add_inertia(l);
  out.set_time(1);
  for (std::uint64_t seed = 1; out.pairs_size() < pairs; ++seed) {
    const TwoPointProblem p = testing::random_frames(n, N, spread, seed);
    Eigen::MatrixXd V = p.Q_T - (p.Q_T * p.Q_0.transpose() + p.Q_0 * p.Q_T.transpose()) / 2 * p.Q_0;
    V *= std::numbers::pi / 2 / V.norm();
    const auto end = geodesic_end(inertia, p.Q_0, V);
    if (!end) continue;
    v1::FramePair& pair = *out.add_pairs();
    write(p.Q_0, *pair.mutable_q_0());
    write(end->Q, *pair.mutable_q_t());
  }
  return out;
}

/// Returns the pairs first, first + 2, ... of a request.
v1::ConnectRequest every_second(const v1::ConnectRequest& whole, int first) {
  v1::ConnectRequest half = whole;
  half.clear_pairs();
  for (int i = first; i < whole.pairs_size(); i += 2) *half.add_pairs() = whole.pairs(i);
  return half;
}

/// Returns the pairs joined in a second.
double rate(const client::Client& client, const v1::ConnectRequest& request) {
  const double seconds = bench::seconds([&] {
    for (const v1::ConnectResponse& joined : client.geodesics(request))
      if (joined.run_status().outcome() != v1::OUTCOME_REACHED)
        throw std::runtime_error("a pair was not joined");
  });
  return request.pairs_size() / seconds;
}

}  // namespace

int main(int, char** argv) {
  const auto two = client::Client::connect(argv[1]), one = client::Client::connect(argv[2]),
             other = client::Client::connect(argv[3]);
  const int repeats = std::stoi(argv[4]), pairs = std::stoi(argv[5]);
  for (const auto& [n, N] : {std::pair(8, 40), {4, 30}, {5, 20}}) {
    bench::Comparison row{.name = std::to_string(pairs) + " pairs of V(" + std::to_string(n) + "," +
                                  std::to_string(N) + "), Λ over 1 : 10, on two threads",
                          .unit = "ms",
                          .rival = "two servers of one thread together",
                          .bound = 1 / 0.85};
    const v1::ConnectRequest all = request(n, N, pairs), even = every_second(all, 0),
                             odd = every_second(all, 1);
    for (int i = 0; i < repeats; ++i) {
      auto second = std::async(std::launch::async, [&] { return rate(other, odd); });
      const double first = rate(one, even), both = first + second.get();
      row.add(1e3 * pairs / rate(two, all), 1e3 * pairs / both);
    }
    report(row);
  }
}
