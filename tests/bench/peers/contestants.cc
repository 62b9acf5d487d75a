// Our methods, Boost.odeint's and the reference, for contest.py. Writes a line of JSON with the
// contestants, then answers every task, {"contestant", "bodies", "time", "setting"}, from stdin.
#include <boost/version.hpp>
#include <iostream>

#include "engine/motion/ensemble.h"
#include "tests/bench/peers/odeint.h"
#include "tests/bench/peers/ours.h"
#include "tests/bench/peers/reference.h"

namespace {

using namespace stiefel;
using namespace stiefel::bench;

std::vector<Contestant> everybody() {
  std::vector<Contestant> all = our_contestants();
  for (Contestant& c : odeint_contestants()) all.push_back(std::move(c));
  all.push_back(reference());
  return all;
}

nlohmann::json answer(const std::vector<Contestant>& all, const nlohmann::json& request) {
  const std::string name = request.at("contestant");
  for (const Contestant& c : all) {
    if (c.name != name) continue;
    try {
      return c.integrate(request.get<Task>());
    } catch (const std::exception& e) {
      return {{"failed", e.what()}};
    }
  }
  throw std::invalid_argument("no contestant " + name);
}

}  // namespace

int main() {
  limit_threads(1);  // one thread, as MuJoCo's models use: the figure is per core
  const std::vector<Contestant> all = everybody();
  nlohmann::json who = nlohmann::json::array();
  for (const Contestant& c : all) {
    const std::string version = c.package == "odeint" ? BOOST_LIB_VERSION : "";
    who.push_back({{"package", c.package},
                   {"version", version},
                   {"name", c.name},
                   {"setting", c.setting},
                   {"work", c.work}});
  }
  std::cout << who << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    std::cout << answer(all, nlohmann::json::parse(line)) << std::endl;
  }
}
