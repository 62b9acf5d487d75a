#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/endpoint.h"
#include "client/cli/interrupt.h"
#include "client/cli/message_file.h"
#include "client/cli/progress/progress.h"
#include "client/cli/report.h"

namespace stiefel::cli {

ExitStatus diagnose(const DiagnoseCommand& command) {
  const v1::Scene scene = read_scene(command.scene);
  const Endpoint endpoint(command.server);
  const auto session = endpoint.create(scene);
  print_remarks(session.description());
  v1::DiagnoseRequest request;
  if (!command.structure.empty()) read_message(command.structure, &request);
  request.set_to(command.to);
  request.mutable_invariants()->Add(command.invariants.begin(), command.invariants.end());
  if (command.symplectic) request.mutable_symplectic_test();
  request.set_estimate_error(error_estimation(command.estimate_error));
  v1::DiagnoseResponse diagnosis;
  {
    const Progress progress(session, command.to);
    try {
      diagnosis = session.diagnose(request);
    } catch (const client::Error&) {
      if (interrupted()) throw Interrupted(progress.how_far());
      throw;
    }
  }
  std::cout << report(diagnosis.run_status(), diagnosis, session.choice()).dump(2) << '\n';
  show_summary(diagnosis);
  return conclude(diagnosis.run_status(), diagnosis.step());
}

}  // namespace stiefel::cli
