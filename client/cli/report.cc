#include "client/cli/report.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <iostream>
#include <numbers>

#include "client/cli/input/message_file.h"
#include "engine/numbers/to_text.h"

namespace stiefel::cli {
namespace {

/// Returns the number of characters in UTF-8 text.
std::size_t width(const std::string& text) {
  return std::ranges::count_if(text, [](char c) { return (c & 0xc0) != 0x80; });
}

std::string without(std::string_view start, std::string name) {
  return name.starts_with(start) ? name.substr(start.size()) : name;
}

/// Returns the estimated error, or the reason why there is none.
nlohmann::ordered_json to_json(const v1::EstimatedError& error) {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  if (error.has_attitude()) out["attitude"] = error.attitude();
  if (error.has_angle()) out["attitude_degrees"] = error.angle() * 180 / std::numbers::pi;
  if (error.has_momentum()) out["momentum"] = error.momentum();
  if (!error.missing().empty()) out["missing"] = error.missing();
  if (error.has_member()) out["member"] = error.member();
  if (!error.reference().empty()) {
    out["reference"] = error.reference();
    out["reference_error"] = error.reference_error();
  }
  out["work"] = error.work();
  out["run_work"] = error.run_work();
  return out;
}

}  // namespace

std::string to_string(v1::Outcome outcome) {
  return without("OUTCOME_", v1::Outcome_Name(outcome));
}

std::string to_string(v1::Conservation conservation) {
  std::string name = without("CONSERVATION_", v1::Conservation_Name(conservation));
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

nlohmann::ordered_json ending(const v1::RunStatus& run_status) {
  nlohmann::ordered_json end = {{"outcome", to_string(run_status.outcome())}};
  if (run_status.outcome() == v1::OUTCOME_REACHED) return end;
  if (run_status.has_largest_step()) end["largest_step"] = run_status.largest_step();
  if (run_status.has_member()) end["member"] = run_status.member();
  end["message"] = run_status.message();
  return end;
}

nlohmann::ordered_json ending(const v1::RunStatus& run_status,
                              const v1::DiagnoseResponse& diagnosis) {
  nlohmann::ordered_json end = ending(run_status);
  if (diagnosis.has_estimated_error())
    end["estimated_error"] =
        cli::to_json(static_cast<const google::protobuf::Message&>(diagnosis.estimated_error()));
  return end;
}

void print_report(const nlohmann::ordered_json& report, const v1::DiagnoseResponse& diagnosis,
                  bool json) {
  if (json || !isatty(STDOUT_FILENO)) {
    std::cout << report.dump(2) << '\n';
    return show_summary(diagnosis);
  }
  std::cout << to_string(diagnosis.run_status().outcome()) << " at step " << diagnosis.step()
            << ", time " << stiefel::to_text(diagnosis.time(), 6) << '\n';
  Rows rows = {{"invariant", "value", "drift", "kept"}};
  for (const auto& invariant : diagnosis.invariants()) {
    std::string name = invariant.name();
    if (invariant.has_member()) name += " of member " + std::to_string(invariant.member());
    rows.push_back({name, stiefel::to_text(invariant.value(), 6),
                    scientific_text(invariant.drift(), 2), to_string(invariant.conservation())});
  }
  if (diagnosis.has_orthogonality())
    rows.push_back({"orthogonality", "", scientific_text(diagnosis.orthogonality(), 2), ""});
  print_table(rows, "  ");
  for (const auto& family : diagnosis.shortened())
    std::cout << "  of " << family.name() << " only those with the largest drift of "
              << family.count() << '\n';
  std::cout << summary(diagnosis) << '\n';
}

nlohmann::ordered_json report(const v1::RunStatus& run_status,
                              const v1::DiagnoseResponse& diagnosis, const v1::Choice* choice) {
  nlohmann::ordered_json invariants = nlohmann::ordered_json::array();
  for (const auto& invariant : diagnosis.invariants()) {
    invariants.push_back({{"name", invariant.name()},
                          {"initial", invariant.initial()},
                          {"value", invariant.value()},
                          {"drift", invariant.drift()},
                          {"scale", invariant.scale()},
                          {"conservation", to_string(invariant.conservation())}});
    if (invariant.has_member()) invariants.back()["member"] = invariant.member();
  }
  nlohmann::ordered_json domain = {{"h_omega", diagnosis.domain().h_omega()}};
  if (diagnosis.domain().has_largest_step()) {
    domain["largest_step"] = diagnosis.domain().largest_step();
  }

  nlohmann::ordered_json report = ending(run_status);
  if (choice != nullptr) report["choice"] = cli::to_json(*choice);
  auto& accuracy = report["diagnosis"];
  accuracy["summary"] = summary(diagnosis);
  accuracy["invariants"] = std::move(invariants);
  for (const auto& family : diagnosis.shortened())
    accuracy["shortened"].push_back({{"name", family.name()}, {"count", family.count()}});
  if (diagnosis.has_orthogonality()) accuracy["orthogonality"] = diagnosis.orthogonality();
  if (diagnosis.has_estimated_error())
    accuracy["estimated_error"] = to_json(diagnosis.estimated_error());
  accuracy["domain"] = std::move(domain);
  if (diagnosis.forms_size() > 0) accuracy["forms"] = diagnosis.forms();
  if (diagnosis.dirac_brackets_size() > 0) accuracy["dirac_brackets"] = diagnosis.dirac_brackets();
  if (diagnosis.has_symplectic_defect())
    accuracy["symplectic_defect"] = diagnosis.symplectic_defect();
  return report;
}

ExitStatus conclude(const v1::RunStatus& run_status, std::int64_t last_step) {
  if (run_status.outcome() == v1::OUTCOME_REACHED) return reached;
  std::cerr << "stiefel: " << to_string(run_status.outcome()) << " after step " << last_step << ": "
            << run_status.message() << '\n';
  return numerical_stop;
}

void print_warnings(const google::protobuf::RepeatedPtrField<std::string>& warnings) {
  for (const std::string& warning : warnings) std::cerr << "warning: " << warning << '\n';
}

void print_remarks(const v1::Session& session) {
  print_warnings(session.warnings());
  if (session.has_choice() && isatty(STDERR_FILENO))
    std::cerr << "stiefel: chose " << session.choice().method().name() << ": "
              << session.choice().reason() << '\n';
}

void print_table(const Rows& rows, const std::string& indent) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  }
  for (const auto& row : rows) {
    std::string line = indent;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += row[i] + std::string(widths[i] - width(row[i]) + 2, ' ');
    }
    std::cout << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
  }
}

}  // namespace stiefel::cli
