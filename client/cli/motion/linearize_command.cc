#include "client/cli/input/message_file.h"
#include "client/cli/input/nested_numbers.h"
#include "client/cli/motion/motion_options.h"
#include "stiefel/client/samples.h"

namespace stiefel::cli {
namespace {

struct LinearizeCommand : MotionCommand {
  std::int64_t every = 0;
  bool inertia = false, step = false;
  /// A file with `vectors`, as in stiefel.v1.LinearizeRequest.
  std::string request;
};

v1::LinearizeRequest request_of(const LinearizeCommand& command) {
  v1::LinearizeRequest request;
  if (!command.request.empty()) {
    read_message(command.request, &request);
    std::vector<const google::protobuf::FieldDescriptor*> given;
    request.GetReflection()->ListFields(request, &given);
    for (const auto* field : given)
      if (field->name() != "vectors")
        throw BadInput(command.request + ": " + field->name() +
                       ": must be absent; the file has `vectors` alone");
  }
  request.set_every(command.every);
  request.set_inertia(command.inertia);
  request.set_step(command.step);
  request.set_bases(request.vectors().shape_size() != 3);
  return request;
}

ExitStatus linearize(const LinearizeCommand& command, Origin& origin) {
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  const auto ask = [&](const auto& session, const auto& request, Progress& progress) {
    return session.linearize(request, [&](const v1::LinearizeResponse& result) {
      progress.at(result.step());
      nlohmann::ordered_json one = {{"step", result.step()}, {"time", result.time()}};
      for (const auto& field : result.fields()) one[field.name()] = as_lists(field.value());
      results.push_back(std::move(one));
      return true;
    });
  };
  return answer(command, origin, request_of(command), ask,
                [&](auto& json, const auto&) { json["results"] = std::move(results); });
}

void add_linearize(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<LinearizeCommand>();
  add_motion(app, *command, "the step at which the vectors start; 0 by default");
  app->add_option("--every", command->every,
                  "a result every K steps too; by default at the last step alone")
      ->transform(whole_number())
      ->type_name("K");
  app->add_flag("--inertia", command->inertia, "adds the derivatives by lambda_1 ... lambda_N");
  app->add_flag("--by-step", command->step, "adds the derivative by the step");
  app->add_option("--request", command->request,
                  "file with `vectors`, which are moved instead of a basis: the JSON form of "
                  "stiefel.v1.LinearizeRequest")
      ->type_name("FILE.json");
  add_end(app, chosen, command,
          {{"every", "--every"},
           {"inertia", "--inertia"},
           {"step", "--by-step"},
           {"vectors", "--request: vectors"}},
          linearize);
}

const Subcommand linearize_command(
    "linearize", "Prints the derivative of the computed steps: the state transition matrix",
    add_linearize);

}  // namespace

}  // namespace stiefel::cli
