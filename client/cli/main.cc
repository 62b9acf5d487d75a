// The command `stiefel`: runs simulations on the server at an address, or on an embedded one.
#include <CLI/CLI.hpp>
#include <cstdlib>
#include <exception>
#include <functional>
#include <iostream>

#include "client/cli/checked_stdout.h"
#include "client/cli/commands.h"
#include "client/cli/input/whole_number.h"
#include "client/cli/interrupt.h"
#include "client/cli/origin.h"
#include "server/command_line.h"
#include "stiefel/client/error.h"

namespace {

using namespace stiefel;
using namespace stiefel::cli;

void add_server(CLI::App* app, Remote& server) {
  auto* address =
      app->add_option(
             "--server", server.address,
             "HOST:PORT or unix:PATH of a server; by default the command runs a server in its own "
             "process")
          ->type_name("ADDRESS");
  app->add_option("--tls-ca", server.tls_ca,
                  "PEM file of the authorities that signed the server's certificate; connects with "
                  "TLS")
      ->envname("STIEFEL_TLS_CA")
      ->type_name("FILE");
  app->add_option("--token-file", server.token_file,
                  "file of the token that identifies the caller; by default the token is the "
                  "variable STIEFEL_TOKEN")
      ->needs(address)
      ->type_name("FILE");
}

constexpr const char* between_steps =
    ": it counts steps; stiefel run --times FILE gives samples between them";

void add_scene(CLI::App* app, std::string& scene, std::int64_t& to) {
  app->add_option("SCENE", scene, "a scene file: the JSON form of stiefel.v1.Scene")
      ->required()
      ->type_name("FILE.json");
  app->add_option("--to", to, "the last step")
      ->required()
      ->transform(whole_number(between_steps))
      ->type_name("STEP");
}

void add_error(CLI::App* app, std::optional<bool>& estimate_error) {
  auto* always = app->add_flag_callback(
      "--error", [&] { estimate_error = true; },
      "estimate the error of attitude and momentum at the last step; by default only where the "
      "estimate takes less work than the run or less than 10 ms");
  app->add_flag_callback(
         "--no-error", [&] { estimate_error = false; }, "do not estimate the error")
      ->excludes(always);
}

void say(const std::string& fault) { std::cerr << "stiefel: error: " + fault + '\n'; }

/// Prints an error to stderr, one line for each fault, and returns the exit status.
ExitStatus explain(const client::Error& error, const Origin& origin) {
  for (const auto& violation : error.violations())
    say(origin.place(violation.field) + ": " + violation.description);
  if (error.violations().empty()) say(error.what());
  if (error.code() == grpc::StatusCode::INVALID_ARGUMENT || !error.violations().empty()) {
    return bad_input;
  }
  const bool unreachable = error.code() == grpc::StatusCode::UNAVAILABLE ||
                           error.code() == grpc::StatusCode::DEADLINE_EXCEEDED;
  return unreachable ? no_server : failed;
}

}  // namespace

int main(int argc, char** argv) {
  // The command explains failures itself. A user who sets GRPC_VERBOSITY gets gRPC's log as well.
  setenv("GRPC_VERBOSITY", "NONE", 0);
  CLI::App app(
      "Simulates torque-free rigid bodies in any dimension and geodesics on Stiefel manifolds, and "
      "reports how accurate the result is.",
      "stiefel");
  app.require_subcommand(1);
  app.set_version_flag("--version", STIEFEL_VERSION);
  app.footer(
      "Exit status: 0 reached, 2 bad input, 3 numerical stop (the samples before it are written),\n"
      "4 the server of --server cannot be reached, 1 any other failure. After Ctrl-C or SIGTERM\n"
      "a command prints the step it reached, removes incomplete files and ends by the signal\n"
      "(status 130, 143). After one second a command prints its progress and the time left on\n"
      "stderr; where stderr is not a terminal, it prints one line every ten seconds.");
  std::function<ExitStatus()> command;
  Origin origin;

  DescribeCommand describe_command;
  auto* describe_app =
      app.add_subcommand("describe", "Lists the systems, methods and limits of a server");
  describe_app->add_flag("--json", describe_command.json, "as JSON: stiefel.v1.DescribeResponse");
  add_server(describe_app, describe_command.server);
  describe_app->callback([&] { command = [&] { return describe(describe_command); }; });

  RunCommand run_command;
  auto* run_app = app.add_subcommand("run", "Runs a scene and writes samples");
  add_scene(run_app, run_command.scene, run_command.to);
  run_app->get_option("--to")->required(false);
  run_app
      ->add_option(
          "--times", run_command.times,
          "file of times, separated by white space, instead of --to: samples at these times, in "
          "the order of the motion. Between two steps the method makes one shorter step from the "
          "state before")
      ->type_name("FILE")
      ->excludes("--to");
  run_app->add_option("--from", run_command.from, "the first sample; 0 by default")
      ->transform(whole_number(between_steps))
      ->type_name("STEP");
  run_app
      ->add_option("--every", run_command.every,
                   "a sample every K steps, and always at the last step. By default a sample at "
                   "every step if these are at most 1000, otherwise at the first and the last")
      ->transform(whole_number())
      ->type_name("K");
  run_app
      ->add_option(
          "--fields", run_command.fields,
          "fields to sample, separated by commas, as `stiefel describe` lists them; by default "
          "quaternion and angular_velocity of a scene with `body`, otherwise the system's blocks")
      ->delimiter(',')
      ->type_name("Q,M,...");
  run_app
      ->add_option("--output", run_command.output,
                   "a .json, .csv or .npz file; by default JSON on stdout. JSON contains outcome "
                   "and diagnosis; with .csv and .npz the command prints them on stdout")
      ->type_name("FILE");
  for (const char* option : {"--from", "--every"}) run_app->get_option("--times")->excludes(option);
  add_error(run_app, run_command.estimate_error);
  add_server(run_app, run_command.server);
  run_app->callback([&] {
    if (run_app->count("--to") + run_app->count("--times") == 0) throw CLI::RequiredError("--to");
    origin = {.file = run_command.scene,
              .options = {{"from", "--from"},
                          {"to", "--to"},
                          {"every", "--every"},
                          {"fields", "--fields"},
                          {"times", "--times"}}};
    command = [&] { return run(run_command, origin); };
  });

  SummarizeCommand summarize_command;
  auto* summarize_app = app.add_subcommand(
      "summarize", "Prints statistics and events of a motion without its samples");
  add_scene(summarize_app, summarize_command.scene, summarize_command.to);
  summarize_app->add_option("--from", summarize_command.from, "the first sample; 0 by default")
      ->transform(whole_number(between_steps))
      ->type_name("STEP");
  summarize_app
      ->add_option("--every", summarize_command.every,
                   "a sample every K steps, and always at the last step; 1 by default")
      ->transform(whole_number())
      ->type_name("K");
  summarize_app
      ->add_option("--quantity", summarize_command.quantities,
                   "NAME is a field, an invariant or a family of invariants; A,B,... are among "
                   "last, min, max, mean, rms, sign_changes, drift. Repeatable. Example: "
                   "energy=drift")
      ->type_name("NAME=A,B,...");
  summarize_app->add_flag("--over-members", summarize_command.over_members,
                          "one statistic over the members of an ensemble instead of one for each");
  summarize_app
      ->add_option(
          "--request", summarize_command.request,
          "file with `quantities` (which may have quantiles and edges), `events` and `fields`: the "
          "JSON form of stiefel.v1.SummarizeRequest")
      ->type_name("FILE.json");
  summarize_app->add_option("--output", summarize_command.output, "a .json file; stdout by default")
      ->type_name("FILE.json");
  add_server(summarize_app, summarize_command.server);
  summarize_app->callback([&] {
    origin = {.file = summarize_command.scene,
              .options = {{"from", "--from"},
                          {"to", "--to"},
                          {"every", "--every"},
                          {"events", "--request: events"},
                          {"fields", "--request: fields"}}};
    command = [&] { return summarize(summarize_command); };
  });

  DiagnoseCommand diagnose_command;
  auto* diagnose_app = app.add_subcommand(
      "diagnose", "Prints invariants, drift, estimated error and domain at a step");
  add_scene(diagnose_app, diagnose_command.scene, diagnose_command.to);
  diagnose_app
      ->add_option("--invariants", diagnose_command.invariants,
                   "families or single invariants, separated by commas; by default all families, "
                   "the Manakov coefficients only up to N = 16")
      ->delimiter(',')
      ->type_name("A,B,...");
  diagnose_app->add_flag("--symplectic", diagnose_command.symplectic,
                         "measures the symplectic defect: the change of the two-form by one step");
  diagnose_app
      ->add_option(
          "--structure", diagnose_command.structure,
          "file of two-forms and Dirac brackets to evaluate: `forms` and `dirac_brackets` of "
          "stiefel.v1.DiagnoseRequest")
      ->type_name("FILE.json");
  add_error(diagnose_app, diagnose_command.estimate_error);
  add_server(diagnose_app, diagnose_command.server);
  diagnose_app->callback([&] {
    origin = {.file = diagnose_command.scene,
              .options = {{"to", "--to"},
                          {"invariants", "--invariants"},
                          {"symplectic_test", "--symplectic"},
                          {"forms", "--structure: forms"},
                          {"dirac_brackets", "--structure: dirac_brackets"}}};
    command = [&] { return diagnose(diagnose_command); };
  });

  ConvertCommand convert_command;
  auto* convert_app =
      app.add_subcommand("convert", "Prints the same motion as a scene of another system");
  convert_app->add_option("SCENE", convert_command.scene, "a scene file")
      ->required()
      ->type_name("FILE.json");
  convert_app
      ->add_option("--to", convert_command.target,
                   "the target: a system, or velocity, angular_velocity, interpolation")
      ->required()
      ->type_name("SYSTEM");
  convert_app->add_option(
      "--epsilon", convert_command.epsilon,
      "epsilon of the symmetric and parametric systems; by default a power of two chosen "
      "from the norm of M");
  convert_app->add_option("--parameter", convert_command.parameter,
                          "mu of the parametric systems; by default the scene's");
  convert_app
      ->add_option("--output", convert_command.output,
                   "file for the converted scene; stdout then has the margins only")
      ->type_name("FILE.json");
  add_server(convert_app, convert_command.server);
  convert_app->callback([&] {
    origin = {.file = convert_command.scene,
              .options = {{"to", "--to"}, {"epsilon", "--epsilon"}, {"parameter", "--parameter"}}};
    command = [&] { return convert(convert_command); };
  });

  TradeoffCommand tradeoff_command;
  auto* tradeoff_app = app.add_subcommand(
      "tradeoff",
      "Measures error against cost of every method and prints the Pareto front: the points that no "
      "other point beats in both work and error");
  tradeoff_app->add_option("SCENE", tradeoff_command.scene, "a scene file; its method is ignored")
      ->required()
      ->type_name("FILE.json");
  tradeoff_app
      ->add_option(
          "--horizon", tradeoff_command.horizon,
          "the time at which errors are measured; by default the scene's horizon, else 100 steps")
      ->type_name("T");
  tradeoff_app
      ->add_option(
          "--budget", tradeoff_command.budget,
          "work in instructions; by default 5e10, about ten seconds. A point that needs more than "
          "its share is measured over a part of the horizon and extrapolated (marked ~)")
      ->type_name("B");
  tradeoff_app->add_flag("--all", tradeoff_command.all,
                         "prints all points, and marks those of the Pareto front with *");
  tradeoff_app
      ->add_option("--repeats", tradeoff_command.repeats, "timed runs of each point; by default 3")
      ->transform(whole_number())
      ->type_name("R");
  tradeoff_app
      ->add_option("--output", tradeoff_command.output, "a .json or .csv file for all points")
      ->type_name("FILE");
  add_server(tradeoff_app, tradeoff_command.server);
  tradeoff_app->callback([&] {
    origin = {
        .file = tradeoff_command.scene,
        .options = {{"horizon", "--horizon"}, {"budget", "--budget"}, {"repeats", "--repeats"}}};
    command = [&] { return tradeoff(tradeoff_command); };
  });

  ConnectCommand connect_command;
  auto* connect_app = app.add_subcommand(
      "connect", "Finds the geodesics that join pairs of frames in a given time");
  connect_app
      ->add_option(
          "FILE", connect_command.file,
          "{inertia, Q_0, Q_T, time}, or {inertia, pairs: [{Q_0, Q_T}, ...], time}: the JSON "
          "form of stiefel.v1.ConnectRequest, in which a frame may also be a list of its rows")
      ->required()
      ->type_name("FILE.json");
  add_server(connect_app, connect_command.server);
  connect_app->callback([&] {
    origin = {.file = connect_command.file, .whole_request = true};
    command = [&] { return connect(connect_command, origin); };
  });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::cerr << server::explain(app, error);
    return bad_input;
  }
  for (const std::string& text : server::unknown_variables())
    std::cerr << "warning: " + text + '\n';
  catch_interrupts();
  try {
    CheckedStdout out;
    const ExitStatus status = command();
    out.flush();
    return status;
  } catch (const Interrupted& how_far) {
    end_interrupted(how_far.what());
  } catch (const BadInput& error) {
    say(error.what());
    return bad_input;
  } catch (const client::Error& error) {
    if (interrupted()) end_interrupted("");
    return explain(error, origin);
  } catch (const std::exception& error) {
    if (interrupted()) end_interrupted("");
    say(error.what());
    return failed;
  }
}
