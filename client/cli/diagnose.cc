#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/endpoint.h"
#include "client/cli/progress.h"
#include "client/cli/report.h"
#include "client/cli/scene_file.h"

namespace stiefel::cli {

ExitStatus diagnose(const DiagnoseCommand& command) {
  const v1::Scene scene = read_scene(command.scene);
  const Endpoint endpoint(command.server);
  const auto session = endpoint.client().create(scene);
  v1::DiagnoseResponse diagnosis;
  {
    const Progress progress(session, command.to);
    diagnosis = session.diagnose(command.to, command.invariants);
  }
  std::cout << report(diagnosis.ending(), diagnosis).dump(2) << '\n';
  return conclude(diagnosis.ending(), diagnosis.step());
}

}  // namespace stiefel::cli
