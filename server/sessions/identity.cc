#include "server/sessions/identity.h"

#include <span>

namespace stiefel::server {
namespace {

class Writer {
 public:
  void number(std::uint64_t value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void text(std::string_view value) {
    number(value.size());
    bytes_.append(value);
  }
  void doubles(std::span<const double> values) {
    number(values.size());
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  void optional(const std::optional<double>& value) {
    number(value.has_value());
    if (value) doubles({&*value, 1});
  }
  void matrix(const RowMatrix& value) {
    number(static_cast<std::uint64_t>(value.rows()));
    doubles({value.data(), static_cast<std::size_t>(value.size())});
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

}  // namespace

std::string identity_of(const Scene& scene) {
  const SceneDescription& description = scene.description();
  Writer out;
  out.text(description.system);
  out.number(description.method.has_value());
  if (const auto& method = description.method) {
    out.text(method->name);
    out.number(static_cast<std::uint64_t>(method->order.value_or(0)));
    out.number(static_cast<std::uint64_t>(method->substeps.value_or(1)));
    out.text(method->arithmetic);
    out.optional(method->tolerance);
    out.text(method->scalar);
  }
  out.doubles(description.inertia);
  out.doubles(description.inertia_u);
  out.doubles(description.inertia_v);
  out.optional(description.epsilon);
  out.optional(description.parameter);
  out.number(description.initial.size());
  for (const auto& [name, block] : description.initial) {
    out.text(name);
    out.matrix(block.values);
    out.matrix(block.imaginary);
  }
  out.number(description.body.has_value());
  if (const auto& body = description.body) {
    out.doubles(body->inertia_tensor);
    out.doubles(body->moments);
    out.doubles(body->attitude);
    out.doubles(body->angular_velocity);
  }
  out.doubles({&description.step, 1});
  out.optional(description.tolerance);
  out.optional(description.horizon);
  out.text(description.choice);
  return out.take();
}

std::uint64_t hash(std::string_view bytes) {
  std::uint64_t value = 0xcbf29ce484222325;
  for (const char byte : bytes) {
    value ^= static_cast<unsigned char>(byte);
    value *= 0x100000001b3;
  }
  return value;
}

}  // namespace stiefel::server
