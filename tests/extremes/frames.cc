#include <gtest/gtest.h>

#include <cmath>

#include "engine/dense/orthogonal.h"
#include "stiefel/catalogue.h"
#include "tests/extremes/bodies.h"
#include "tests/extremes/extremes.h"

namespace stiefel::extremes {
namespace {

/// A Q with a defect of up to 1e-6 is accepted and repaired, a larger defect is refused, for every
/// system with a frame.
TEST(Frames, OffOrthogonality) {
  for (int k = 15; k >= 4; --k)
    for (const bool body : {true, false}) {
      const double off = std::pow(10, -k) * (k == 6 ? 0.999 : 1);
      SceneDescription d =
          body ? tumbling(spread_inertia(4, 3), 0.1) : geodesic(2, spread_inertia(5, 3), 0.1);
      d.method = MethodDescription{"variational", {}, {}, ""};
      RowMatrix& Q = d.initial.at("Q").values;
      // Stretches a row, so that max |QQᵀ − I| is `off`.
      Q.row(0) *= std::sqrt(1 + off);
      const Trial done = run(d, 100);
      Record r = record_of("frames", "Q off by 1e-" + std::to_string(k), d, done);
      if (k >= 6) {
        r.measure = "orthogonality";
        r.value = done.reached() ? *done.simulation->orthogonality() : 1;
        r.bound = rounding_bound(*done.scene, 100, 1);
        r.why = rounding_reason(*done.scene, 1) + "; taken and repaired up to 1e-6";
      } else {
        r.measure = "refused with a rule";
        r.value =
            done.outcome() != "REFUSED" || done.sentence().find("orthonormal") == std::string::npos;
        r.why = "beyond 1e-6 it is another frame";
      }
      report(r);
    }
}

/// A frame with det Q = −1 moves like any other.
TEST(Frames, Reflections) {
  SceneDescription three = top({1, 1.7, 2.4}, {0.8, -0.5, 0.4}, 0.1);
  three.initial.at("Q").values.row(1) *= -1;
  measure({"frames", "det Q = -1", three, 100});
  SceneDescription four = tumbling(spread_inertia(4, 3), 0.1);
  four.initial.at("Q").values.row(1) *= -1;
  measure({"frames", "det Q = -1, N = 4", four, 100});
}

/// K = QΛ⁻¹Qᵀ has clustered eigenvalues, which coincide at Λ = I.
TEST(Frames, ClusteredK) {
  for (const int k : {1, 4, 8, 12, 15}) {
    if (!long_form() && k % 8 != 0) continue;
    Eigen::VectorXd lambda(6);
    for (int i = 0; i < 6; ++i) lambda(i) = 1 + i * std::pow(10, -k);
    measure({"frames", "K clustered to 1e-" + std::to_string(k), geodesic(3, lambda, 0.1), 50});
  }
  // Two clusters of λ.
  Eigen::VectorXd lambda(6);
  lambda << 1, 1 + 1e-12, 1 + 1e-9, 100, 100 + 1e-9, 100 + 1e-7;
  measure({"frames", "K in two clusters", geodesic(3, lambda, 0.02), 50});
}

}  // namespace
}  // namespace stiefel::extremes
