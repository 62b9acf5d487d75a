// Joins pairs of frames in the metric of β. Arguments: n, N, β, a file of the pairs: Q_0, Q_T and
// Q̇(0) for each, as rows of doubles. For every index of a pair that it reads from stdin it writes
// the seconds of a search and the largest error of its velocity.
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <vector>

#include "stiefel/connect.h"
#include "tests/bench/measure.h"

int main(int, char** argv) {
  using namespace stiefel;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const int n = std::stoi(argv[1]), N = std::stoi(argv[2]);
  const double beta = std::stod(argv[3]);
  std::ifstream file(argv[4], std::ios::binary);
  const auto block = [&] {
    RowMajor rows(n, N);
    file.read(reinterpret_cast<char*>(rows.data()),
              static_cast<std::streamsize>(sizeof(double)) * rows.size());
    return Eigen::MatrixXd(rows);
  };
  std::vector<TwoPointProblem> problems;
  std::vector<Eigen::MatrixXd> velocities;
  while (file.peek() != std::ifstream::traits_type::eof()) {
    TwoPointProblem problem;
    if (beta == 1)
      problem.inertia.setOnes(N);
    else
      problem.beta = beta;
    problem.Q_0 = block();
    problem.Q_T = block();
    problems.push_back(std::move(problem));
    velocities.push_back(block());
  }
  for (std::size_t pair = 0; std::cin >> pair;) {
    double error = 0;
    const double seconds = bench::processor_seconds([&] {
      const auto answer = connect(problems[pair]);
      if (!answer) throw std::runtime_error("a pair was not joined");
      error = (answer->Qdot - velocities[pair]).cwiseAbs().maxCoeff();
    });
    std::cout << seconds << ' ' << error << std::endl;
  }
}
