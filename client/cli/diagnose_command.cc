#include "client/cli/command.h"
#include "client/cli/endpoint.h"
#include "client/cli/input/message_file.h"
#include "client/cli/interrupt.h"
#include "client/cli/options.h"
#include "client/cli/progress/progress.h"
#include "client/cli/report.h"

namespace stiefel::cli {

namespace {

struct DiagnoseCommand {
  SceneSource scene;
  Remote server;
  std::vector<std::string> invariants;
  /// A file with `forms` and `dirac_brackets`, as in stiefel.v1.DiagnoseRequest.
  std::string structure;
  bool symplectic = false;
  bool json = false;
  std::optional<bool> estimate_error;
};

ExitStatus diagnose(const DiagnoseCommand& command, Origin& origin) {
  const v1::Scene scene = read_scene(command.scene, origin);
  const std::int64_t to = last_step(command.scene, scene);
  const Endpoint endpoint(command.server);
  const auto session = endpoint.create(scene);
  print_remarks(session.description());
  v1::DiagnoseRequest request;
  if (!command.structure.empty()) read_message(command.structure, &request);
  request.set_to(to);
  request.mutable_invariants()->Add(command.invariants.begin(), command.invariants.end());
  if (command.symplectic) request.mutable_symplectic_test();
  request.set_estimate_error(error_estimation(command.estimate_error));
  v1::DiagnoseResponse diagnosis;
  {
    const Progress progress(session, to);
    try {
      diagnosis = session.diagnose(request);
    } catch (const client::Error&) {
      if (interrupted()) throw Interrupted(progress.how_far());
      throw;
    }
  }
  print_report(report(diagnosis.run_status(), diagnosis, session.choice()), diagnosis,
               command.json);
  return conclude(diagnosis.run_status(), diagnosis.step());
}

void add_diagnose(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<DiagnoseCommand>();
  add_run_of_scene(app, command->scene);
  app->add_option("--invariants", command->invariants,
                  "families or single invariants, separated by commas; by default all families, "
                  "the Manakov coefficients only up to N = 16")
      ->delimiter(',')
      ->type_name("A,B,...");
  app->add_flag("--symplectic", command->symplectic,
                "measures the symplectic defect: the change of the two-form by one step");
  app->add_option(
         "--structure", command->structure,
         "file of two-forms and Dirac brackets to evaluate: `forms` and `dirac_brackets` of "
         "stiefel.v1.DiagnoseRequest")
      ->type_name("FILE.json");
  app->add_flag("--json", command->json,
                "prints everything as JSON, also on a terminal, where a table is the default");
  add_error(app, command->estimate_error);
  add_server(app, command->server);
  app->callback([=, &chosen] {
    chosen.origin = {.file = command->scene.shown(),
                     .options = {{"to", command->scene.time ? "--time" : "--to"},
                                 {"invariants", "--invariants"},
                                 {"symplectic_test", "--symplectic"},
                                 {"forms", "--structure: forms"},
                                 {"dirac_brackets", "--structure: dirac_brackets"}}};
    chosen.run = [command](Origin& origin) { return diagnose(*command, origin); };
  });
}

const Subcommand diagnose_command("diagnose",
                                  "Prints invariants, drift, estimated error and domain at a step",
                                  add_diagnose);

}  // namespace

}  // namespace stiefel::cli
