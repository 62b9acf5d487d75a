#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <iostream>
#include <sstream>

#include "client/cli/command.h"
#include "client/cli/endpoint.h"
#include "client/cli/options.h"
#include "client/cli/report.h"
#include "engine/numbers/to_text.h"

namespace stiefel::cli {
namespace {

struct DescribeCommand {
  Remote server;
  bool json = false;
};

std::string preserves(const v1::MethodOnSystem& method) {
  std::string text;
  for (const auto& p : method.preserves()) {
    text += (text.empty() ? "" : ", ") + p.invariant() + " " + to_string(p.conservation());
  }
  return text;
}

/// Returns, for example, "variational of order 8, plain, h|Omega| of a substep up to 0.15".
std::string text(const v1::Recommendation& recommended) {
  const v1::Method& method = recommended.method();
  std::ostringstream out;
  out << method.name();
  if (method.has_order()) out << " of order " << method.order();
  if (method.has_tolerance()) out << " with tolerance " << stiefel::to_text(method.tolerance());
  out << ", " << method.arithmetic();
  if (recommended.largest_h_omega() > 0)
    out << ", h|Omega| of a substep up to " << stiefel::to_text(recommended.largest_h_omega());
  if (recommended.largest_h_momentum_rate() > 0)
    out << ", h(|M''|/|M|)^1/2 of a substep up to "
        << stiefel::to_text(recommended.largest_h_momentum_rate());
  if (recommended.largest_h_velocity_rate() > 0)
    out << ", h(|q'''|/|q'|)^1/2 of a substep up to "
        << stiefel::to_text(recommended.largest_h_velocity_rate());
  return out.str();
}

void print(const v1::SystemInfo& system) {
  std::cout << '\n'
            << system.name() << (system.discrete() ? " (discrete)" : "") << ": " << system.summary()
            << "\n  " << system.equations() << "  (" << system.source() << ")\n";
  Rows rows;
  for (const auto& block : system.blocks()) {
    rows.push_back({"block", block.name(), block.shape(),
                    block.description() + (block.required() ? "" : " (optional)")});
  }
  for (const auto& field : system.fields()) {
    rows.push_back({"field", field.name(), field.shape(), field.description()});
  }
  for (const auto& invariant : system.invariants()) {
    rows.push_back({"invariant", invariant.name(), "", invariant.formula()});
  }
  for (const auto& form : system.forms()) {
    rows.push_back({"form", form.name(), form.blocks(), form.formula()});
  }
  print_table(rows, "  ");
  rows.clear();
  for (const auto& method : system.methods()) {
    std::string name = method.method().empty() ? "(the map)" : method.method();
    if (!method.where().empty()) name += " (" + method.where() + ")";
    if (method.in_float()) name += ", float too";
    rows.push_back({"keeps", name, preserves(method)});
  }
  for (const auto& recommended : system.recommended()) {
    rows.push_back({"recommended",
                    recommended.where().empty() ? "(every scene)" : recommended.where(),
                    text(recommended)});
  }
  print_table(rows, "  ");
}

void print(const v1::MethodInfo& method, Rows& rows) {
  std::string orders;
  for (const auto order : method.orders()) {
    orders += (orders.empty() ? "" : ", ") + std::to_string(order);
  }
  rows.push_back({method.name(), orders.empty() ? "exact" : "order " + orders,
                  method.reversible() ? "reversible" : "", method.summary(), method.source()});
}

ExitStatus describe(const DescribeCommand& command) {
  const Endpoint endpoint(command.server);
  const v1::DescribeResponse reply = endpoint.client().describe();
  if (command.json) {
    google::protobuf::util::JsonPrintOptions options;
    options.add_whitespace = true;
    options.always_print_primitive_fields = true;
    options.preserve_proto_field_names = true;
    std::string text;
    const auto status = google::protobuf::util::MessageToJsonString(reply, &text, options);
    if (!status.ok()) throw std::runtime_error(status.ToString());
    std::cout << text;
    return reached;
  }
  std::cout << "stiefel " << reply.version() << "\nnumerics id: " << reply.numerics_id()
            << "\nbuild: " << reply.build() << "\nsessions: "
            << (reply.durable() ? "on disk" : "in memory, lost when the server ends")
            << "\n\nMethods\n";
  Rows methods;
  for (const auto& method : reply.methods()) print(method, methods);
  print_table(methods, "  ");
  std::cout << "\nSystems\n";
  for (const auto& system : reply.systems()) print(system);
  const auto& limits = reply.limits();
  std::cout << "\nLimits\n";
  print_table({{"dimension N", std::to_string(limits.max_dimension())},
               {"members", std::to_string(limits.max_members())},
               {"step index", std::to_string(limits.max_step())},
               {"sessions", std::to_string(limits.max_sessions())},
               {"message to the server, bytes", std::to_string(limits.max_message_bytes())},
               {"arrays of one reply, bytes", std::to_string(limits.max_reply_bytes())},
               {"cached steps of a session", std::to_string(limits.max_cached_steps())},
               {"idle time, seconds", std::to_string(limits.idle_timeout().seconds())}},
              "  ");
  return reached;
}

void add_describe(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<DescribeCommand>();
  app->add_flag("--json", command->json, "as JSON: stiefel.v1.DescribeResponse");
  add_server(app, command->server);
  app->callback([=, &chosen] { chosen.run = [command](Origin&) { return describe(*command); }; });
}

const Subcommand describe_command("describe", "Lists the systems, methods and limits of a server",
                                  add_describe);

}  // namespace

}  // namespace stiefel::cli
