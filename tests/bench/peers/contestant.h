#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace stiefel::bench {

/// A free body, moments in kg m², angular velocity in rad/s in body axes. At t = 0 the body axes
/// coincide with the space axes.
struct Body {
  std::array<double, 3> moments, angular_velocity;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Body, moments, angular_velocity)

/// Bodies to be integrated from 0 to `time`. `setting`: the number of steps, or a tolerance.
struct Task {
  std::vector<Body> bodies;
  double time, setting;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Task, bodies, time, setting)

/// The final state of a body: Hamilton's quaternion of its attitude, w first, and ω in body axes.
struct End {
  std::array<double, 4> attitude;
  std::array<double, 3> angular_velocity;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(End, attitude, angular_velocity)

/// The result of a task: seconds of processor time without preparation, the work in the
/// contestant's own units, and the final states.
struct Answer {
  double seconds;
  std::int64_t work;
  std::vector<End> ends;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Answer, seconds, work, ends)

/// A method of a package that integrates bodies. `integrate` solves a task; it throws when it
/// cannot.
struct Contestant {
  std::string package, name;
  std::string setting;  ///< "steps" or "tolerance"
  std::string work;     ///< the unit of its work: "steps" or "evaluations"
  std::function<Answer(const Task&)> integrate;
};

}  // namespace stiefel::bench
