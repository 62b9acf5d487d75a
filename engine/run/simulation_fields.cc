#include "stiefel/simulation.h"

#include <algorithm>
#include <stdexcept>

namespace stiefel {

std::optional<RunStatus> Simulation::advance_slice(std::int64_t steps, double slice,
                                                   const std::stop_token& stop) {
  const bool all = direct() || static_cast<double>(steps) <= slice;
  return advance(all ? steps : static_cast<std::int64_t>(std::max(slice, 1.0)), stop);
}

Eigen::MatrixXd Simulation::get(std::string_view name) const {
  const auto field = std::ranges::find(fields_, name, &Field::name);
  if (field == fields_.end())
    throw std::invalid_argument("the scene has no field " + std::string(name));
  const int rows = field->rows * std::max(1, field->members);
  RowMatrix value(rows, field->size() / rows);
  write(static_cast<std::size_t>(field - fields_.begin()),
        {value.data(), static_cast<std::size_t>(field->size())});
  return value;
}

}  // namespace stiefel
