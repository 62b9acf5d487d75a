#pragma once

#include <Eigen/Core>

/// The work of the pieces of a two-point search between frames of n × N, in instructions, to which
/// the search looks before each. Fits of callgrind's counts for 1 × 2 to 16 × 16 and 1 × 120,
/// within 15 % each; tests/bench/prices.py --caps compares whole searches.
namespace stiefel::connect_work {

/// Degrees of freedom of a frame.
inline double degrees(double n, double N) { return n * N - n * (n + 1) / 2; }

/// The frame nearest to a matrix.
inline double polar(double n, double N) { return 3700 + 43 * n * N + 13 * n * n * N + 420 * n * n; }
/// The planes of a rotation, a frame of a path of rotations, and one of a straight path.
inline double planes(double N) { return 2100 * N * N + 25 * N * N * N; }
inline double turned(double N) { return 1500 + 118 * N * N; }
inline double straight(double n, double N) {
  return 5100 + 36 * n * N + 29 * n * n * N + 900 * n * n;
}
/// One frame's part of the quadratic model of the action, of its solution, and of the step.
inline double model(double n, double N) {
  const double d = degrees(n, N);
  return 6900 + 135 * n * N * d + 4.9 * n * N * d * d + 44 * n * (n + 1) * N + 59 * N * N;
}
inline double solution(double n, double N) {
  const double d = degrees(n, N);
  return 1500 + 1000 * d + 100 * d * d + 5 * d * d * d;
}
inline double move(double n, double N) { return polar(n, N) + 4 * n * N * degrees(n, N); }
/// The action, and the distance of two paths, of so many frames.
inline double action(double frames, double n, double N) { return frames * (300 + 10 * n * N); }
inline double distance(double frames, double n, double N) { return frames * (60 + 4 * n * N); }

/// One attempt of a step of the flow in extended precision, and one evaluation of a variation's
/// derivative in double precision, the field's own share included.
inline double flow(double n, double N) {
  if (n == N) return 7400 + 1500 * N * N + 330 * N * N * N;
  return 16000 + 1800 * n * N + 215 * n * n * N + 610 * n * n * n + 8800 * n * n;
}
inline double variation(double n, double N) {
  return n == N ? 2700 + 48 * N * N * N : 5800 + 69 * n * n * N;
}

}  // namespace stiefel::connect_work
