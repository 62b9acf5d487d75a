#include "client/cli/motion/motion_options.h"

namespace stiefel::cli {

void add_motion(CLI::App* app, MotionCommand& command, const char* from) {
  add_run_of_scene(app, command.scene);
  app->add_option("--from", command.from, from)
      ->transform(whole_number(between_steps))
      ->type_name("STEP");
}

void add_output(CLI::App* app, MotionCommand& command) {
  app->add_option("--output", command.output, "a .json file; stdout by default")
      ->type_name("FILE.json");
  add_server(app, command.server);
}

}  // namespace stiefel::cli
