// Makes a given number of steps, alone or with tangent vectors, and nothing else, so that callgrind
// can count them. Arguments: method; N of a rigid body, or n,N of V(n, N); order; vectors, 0 for
// the steps alone; steps.
#include "stiefel/linearization.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"

namespace {

using namespace stiefel;

SceneDescription description_of(const std::string& shape, double step) {
  const auto comma = shape.find(',');
  const int N = std::stoi(shape.substr(comma == std::string::npos ? 0 : comma + 1));
  if (comma == std::string::npos)
    return testing::description(testing::RandomBody(N, 1), step, "variational");
  const testing::RandomFrame<double> frame(std::stoi(shape), N, 1);
  SceneDescription d;
  d.system = "stiefel";
  d.method.emplace();
  d.inertia = {frame.lambda.begin(), frame.lambda.end()};
  d.initial["Q"] = frame.Q;
  d.initial["S"] = frame.S;
  d.step = step;
  return d;
}

}  // namespace

int main(int, char** argv) {
  SceneDescription d = description_of(argv[2], 0.05);
  d.method->name = argv[1];
  if (const int order = std::stoi(argv[3]); order > 0) d.method->order = order;
  const Eigen::Index vectors = std::stoi(argv[4]);
  const std::int64_t steps = std::stoll(argv[5]);
  const Scene scene = Scene::resolve(std::move(d)).value();
  const auto motion = make_simulation(scene);
  if (vectors == 0) return motion->advance(steps).reached() ? 0 : 1;
  // A shift of the velocity along itself is tangent.
  Eigen::MatrixXd x(2 * motion->get("Q").rows(), scene.dimension());
  x << Eigen::MatrixXd::Zero(x.rows() / 2, x.cols()),
      motion->get(scene.system() == "stiefel" ? "S" : "M");
  const Eigen::VectorXd v = x.reshaped<Eigen::RowMajor>();
  auto tangent = Linearization::make(scene, {v.replicate(1, vectors), true, false, false}, *motion);
  return tangent && (*tangent)->advance(*motion, steps).reached() ? 0 : 1;
}
