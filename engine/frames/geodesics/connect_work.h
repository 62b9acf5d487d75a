#pragma once

#include <Eigen/Core>

/// The work, in instructions, of the pieces of a two-point search between n × N frames; the search
/// announces it to `stop_point` before each piece. The formulas fit callgrind's counts for 1 × 2 to
/// 16 × 16 and 1 × 120 within 15 % each; tests/bench/prices.py --caps compares whole searches.
namespace stiefel::connect_work {

/// Returns the degrees of freedom of a frame.
inline double degrees(double n, double N) { return n * N - n * (n + 1) / 2; }

/// Returns the work of finding the frame nearest to a matrix.
inline double polar(double n, double N) { return 3700 + 43 * n * N + 13 * n * n * N + 420 * n * n; }
/// Return the work of finding the planes of a rotation, of one frame of a path of rotations, and of
/// one frame of a straight path.
inline double planes(double N) { return 2100 * N * N + 25 * N * N * N; }
inline double turned(double N) { return 1500 + 118 * N * N; }
inline double straight(double n, double N) {
  return 5100 + 36 * n * N + 29 * n * n * N + 900 * n * n;
}
/// Return, for one frame, the work of the quadratic model of the action, of its solution, and of
/// the step.
inline double model(double n, double N) {
  const double d = degrees(n, N);
  return 6900 + 135 * n * N * d + 4.9 * n * N * d * d + 44 * n * (n + 1) * N + 59 * N * N;
}
inline double solution(double n, double N) {
  const double d = degrees(n, N);
  return 1500 + 1000 * d + 100 * d * d + 5 * d * d * d;
}
inline double move(double n, double N) { return polar(n, N) + 4 * n * N * degrees(n, N); }
/// Return the work of computing the action of a path, and the distance of two paths, of `frames`
/// frames.
inline double action(double frames, double n, double N) { return frames * (300 + 10 * n * N); }
inline double distance(double frames, double n, double N) { return frames * (60 + 4 * n * N); }

/// Return the work of one attempt of a step of the flow in extended precision, and of one
/// evaluation of the derivative of a variation in double precision, which includes the field.
inline double flow(double n, double N) {
  if (n == N) return 7400 + 1500 * N * N + 330 * N * N * N;
  return 16000 + 1800 * n * N + 215 * n * n * N + 610 * n * n * n + 8800 * n * n;
}
inline double variation(double n, double N) {
  return n == N ? 2700 + 48 * N * N * N : 5800 + 69 * n * n * N;
}

/// Return the work of the span of two frames, and of one shot of the metric ‖Q̇‖² in R^{n+p}.
inline double span(double n, double N) { return 20000 + 400 * n * n + 24 * n * n * N; }
inline double shot(double n, double p) {
  const double m = n + p;
  return 60000 + 400 * m * m + 16 * m * m * m;
}

/// Return the work of a Relaxation with K inner nodes: of the gradient, of the eigenvalue problem,
/// of one block of the equations of the multipliers with `groups` different λ, of the products of
/// the columns for negative eigenvalues, and of one step; and of one Taylor series of a geodesic.
inline double nodal_gradient(double n, double N, double K) {
  return 1000 + N * (200 + 4 * n * K * (K + 2));
}
inline double nodal_spectrum(double n, double N, double K) {
  const double m = n * K;
  return 5000 + 20 * m * m * m + 600 * m * m + 6 * n * m * N + K * m * m;
}
inline double nodal_block(double n, double N, double groups, double K) {
  const double square = n * n;
  return 2000 + 3 * square * K * n * (groups + 4) + N * (40 + 3 * square) +
         3 * square * square * (groups + 3);
}
inline double nodal_capacity(double unknowns, double negative) {
  return 3000 + unknowns * negative * (negative + 20);
}
inline double nodal_step(double n, double N, double K) {
  const double m = n * K;
  return 5000 + 8 * m * m * N + 8 * n * m * N + m * m * n * n;
}
inline double series(double n, double N) { return 450000 + 300 * (8 * n * n * N + 10 * n * n * n); }

}  // namespace stiefel::connect_work
