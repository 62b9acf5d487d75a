#include "server/sessions/field_bytes.h"

#include <algorithm>
#include <bit>

namespace stiefel::server {

static_assert(std::endian::native == std::endian::little);

bool is_float(const Session& session, std::size_t index) {
  const bool complex = index < session.fields().size() && session.fields()[index].complex;
  return session.scene().in_float() && !complex;
}

std::size_t field_bytes(const Session& session, std::size_t index) {
  return field_size(session.fields(), index) *
         (is_float(session, index) ? sizeof(float) : sizeof(double));
}

std::size_t sample_bytes(const Session& session, const std::vector<std::size_t>& fields) {
  std::size_t bytes = 0;
  for (const std::size_t index : fields) bytes += field_bytes(session, index);
  return bytes;
}

void write_field(const Session& session, const Simulation& simulation, std::size_t index,
                 char* out) {
  const std::size_t size = field_size(session.fields(), index);
  if (!is_float(session, index))
    return simulation.write(index, {reinterpret_cast<double*>(out), size});
  std::vector<double> numbers(size);
  simulation.write(index, numbers);
  std::ranges::transform(numbers, reinterpret_cast<float*>(out),
                         [](double number) { return static_cast<float>(number); });
}

}  // namespace stiefel::server
