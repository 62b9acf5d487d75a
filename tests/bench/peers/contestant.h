#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace stiefel::bench {

/// A free body whose axes lie along those of space at t = 0. kg m², rad/s in body axes.
struct Body {
  std::array<double, 3> moments, angular_velocity;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Body, moments, angular_velocity)

/// Bodies to be turned from 0 to `time`, and how finely: the number of steps, or a tolerance.
struct Task {
  std::vector<Body> bodies;
  double time, setting;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Task, bodies, time, setting)

/// A body at the end: Hamilton's quaternion of its attitude, w first, and ω in body axes.
struct End {
  std::array<double, 4> attitude;
  std::array<double, 3> angular_velocity;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(End, attitude, angular_velocity)

/// Processor seconds without preparation; work in the contestant's own units.
struct Answer {
  double seconds;
  std::int64_t work;
  std::vector<End> ends;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Answer, seconds, work, ends)

/// A program and method that integrate bodies. `turn` throws when it cannot.
struct Contestant {
  std::string package, name;
  std::string setting;  ///< "steps" or "tolerance"
  std::string work;     ///< what is counted: "steps" or "evaluations"
  std::function<Answer(const Task&)> turn;
};

}  // namespace stiefel::bench
