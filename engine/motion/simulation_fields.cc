#include "stiefel/simulation.h"

#include <algorithm>
#include <stdexcept>

#include "engine/dense/euler_angles.h"

namespace stiefel {

std::optional<RunStatus> Simulation::advance_slice(std::int64_t steps, double slice,
                                                   const std::stop_token& stop) {
  const bool all = direct() || static_cast<double>(steps) <= slice;
  return advance(all ? steps : static_cast<std::int64_t>(std::max(slice, 1.0)), stop);
}

std::optional<std::size_t> find_field(const std::vector<Field>& listed, std::string_view name) {
  const auto index = [&](std::string_view of) {
    return static_cast<std::size_t>(std::ranges::find(listed, of, &Field::name) - listed.begin());
  };
  if (const std::size_t found = index(name); found < listed.size()) return found;
  const auto euler = EulerField::named(name);
  if (!euler || index("quaternion") == listed.size()) return std::nullopt;
  return listed.size() + euler->code();
}

Field field_at(const std::vector<Field>& listed, std::size_t index) {
  if (index < listed.size()) return listed[index];
  const EulerField euler = EulerField::with_code(index - listed.size());
  return {euler.name(), 1, 3, false, listed.front().members, !euler.rates};
}

std::size_t field_size(const std::vector<Field>& listed, std::size_t index) {
  const bool euler = index >= listed.size();
  return static_cast<std::size_t>(euler ? 3 * std::max(1, listed.front().members)
                                        : listed[index].size());
}

std::string field_names(const std::vector<Field>& listed) {
  std::string out;
  for (const Field& field : listed) out += (out.empty() ? "" : ", ") + field.name;
  if (find_field(listed, "euler_angles_XYZ"))
    out += ", euler_angles_SEQUENCE, euler_rates_SEQUENCE (of XYZ, ZXZ, xyz, ...)";
  return out;
}

Eigen::MatrixXd Simulation::get(std::string_view name) const {
  const auto index = find_field(fields_, name);
  if (!index) throw std::invalid_argument("the scene has no field " + std::string(name));
  const Field field = field_at(fields_, *index);
  const int rows = field.rows * std::max(1, field.members);
  RowMatrix value(rows, field.size() / rows);
  write(*index, {value.data(), static_cast<std::size_t>(field.size())});
  return value;
}

}  // namespace stiefel
