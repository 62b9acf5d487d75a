#include "proto/checksum/checksum.h"

#include <map>
#include <string_view>
#include <type_traits>

#include "proto/checksum/crc32c.h"

namespace stiefel::wire {
namespace {

/// Accumulates a CRC-32C over little-endian numbers and the bytes of tensors.
class Crc {
 public:
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void add(Number number) { add_bytes(&number, sizeof number); }
  template <class Number>
  void add(const google::protobuf::RepeatedField<Number>& numbers) {
    add_bytes(numbers.data(), static_cast<std::size_t>(numbers.size()) * sizeof(Number));
  }
  void add(const google::protobuf::RepeatedPtrField<v1::Field>& fields) {
    for (const auto& field : fields) add(field);
  }
  void add(const v1::Field& field) { add(std::string_view(field.value().data())); }
  void add(std::string_view bytes) { value_ = crc32c(bytes, value_); }
  /// Adds a number that may be absent.
  template <class Number>
  void add_if(bool present, Number number) {
    if (present) add(number);
  }

  void add(const v1::Scene& scene) {
    add(scene.inertia());
    add(scene.inertia_u());
    add(scene.inertia_v());
    add(scene.body().inertia_tensor());
    add(scene.body().moments());
    add(scene.body().attitude());
    add(scene.body().angular_velocity());
    std::map<std::string_view, const v1::Matrix*> blocks;
    for (const auto& [name, block] : scene.initial()) blocks[name] = &block;
    for (const auto& [name, block] : blocks) {
      add(block->values());
      add(block->imaginary());
    }
  }

  std::uint32_t value() const { return value_; }

 private:
  void add_bytes(const void* bytes, std::size_t size) {
    add(std::string_view(static_cast<const char*>(bytes), size));
  }

  std::uint32_t value_ = 0;
};

/// Returns the CRC-32C of the parts of a message, one after another.
template <class... Parts>
std::uint32_t crc_of(const Parts&... parts) {
  Crc crc;
  (crc.add(parts), ...);
  return crc.value();
}

std::uint32_t checksum_of(const v1::TradeoffPoint& point) {
  Crc crc;
  crc.add_if(point.method().has_order(), point.method().order());
  crc.add_if(point.method().has_substeps(), point.method().substeps());
  crc.add_if(point.method().has_tolerance(), point.method().tolerance());
  crc.add_if(point.has_attitude_error(), point.attitude_error());
  crc.add_if(point.has_momentum_error(), point.momentum_error());
  crc.add(point.drift());
  crc.add(point.work());
  crc.add(point.cpu_seconds_per_second());
  crc.add(point.steps_per_second());
  crc.add(point.measured_steps());
  return crc.value();
}

}  // namespace

std::uint32_t checksum(const v1::Sample& sample) {
  return crc_of(sample.step(), sample.time(), sample.fields());
}

std::uint32_t checksum(const v1::StreamResponse& batch) {
  return crc_of(batch.steps(), batch.times(), batch.fields(), batch.scene_arrays(),
                std::string_view(batch.checkpoint().data()));
}

std::uint32_t checksum(const v1::DiagnoseResponse& diagnosis) {
  Crc crc;
  crc.add(diagnosis.step());
  crc.add(diagnosis.time());
  for (const auto& invariant : diagnosis.invariants())
    for (const double number :
         {invariant.initial(), invariant.value(), invariant.drift(), invariant.scale()})
      crc.add(number);
  return crc.value();
}

std::uint32_t details_checksum(const v1::DiagnoseResponse& diagnosis) {
  Crc crc;
  for (const auto& invariant : diagnosis.invariants())
    crc.add_if(invariant.has_member(), invariant.member());
  crc.add_if(diagnosis.has_orthogonality(), diagnosis.orthogonality());
  crc.add_if(diagnosis.has_domain(), diagnosis.domain().h_omega());
  crc.add_if(diagnosis.domain().has_largest_step(), diagnosis.domain().largest_step());
  crc.add(diagnosis.forms());
  crc.add(diagnosis.dirac_brackets());
  crc.add_if(diagnosis.has_symplectic_defect(), diagnosis.symplectic_defect());
  if (!diagnosis.has_estimated_error()) return crc.value();
  const v1::EstimatedError& error = diagnosis.estimated_error();
  crc.add_if(error.has_attitude(), error.attitude());
  crc.add_if(error.has_momentum(), error.momentum());
  crc.add_if(error.has_angle(), error.angle());
  for (const double number : {error.reference_error(), error.work(), error.run_work()})
    crc.add(number);
  crc.add_if(error.has_member(), error.member());
  return crc.value();
}

std::uint32_t checksum(const v1::ConvertResponse& conversion) {
  return crc_of(conversion.scene(), conversion.scene_arrays(), conversion.blocks());
}

std::uint32_t checksum(const v1::ConnectResponse& geodesic) {
  return crc_of(geodesic.scene(), geodesic.trajectory());
}

std::uint32_t checksum(const v1::SummarizeResponse& part) {
  const v1::EventBatch& events = part.events();
  const v1::StateBatch& states = part.states();
  return crc_of(part.step(), events.events(), events.steps(), events.fractions(), events.times(),
                events.members(), events.fields(), states.steps(), states.times(), states.fields(),
                std::string_view(part.checkpoint().data()), part.statistics());
}

std::uint32_t checksum(const v1::Session& session) { return crc_of(session.scene()); }

std::uint32_t checksum(const v1::MeasureTradeoffResponse& part) {
  switch (part.part_case()) {
    case v1::MeasureTradeoffResponse::kSetup: {
      const v1::TradeoffSetup& setup = part.setup();
      return crc_of(setup.reference_error(), setup.horizon(), setup.steps(),
                    setup.reference_steps(), setup.budget(), setup.repeats(), setup.curves());
    }
    case v1::MeasureTradeoffResponse::kPoint:
      return checksum_of(part.point());
    case v1::MeasureTradeoffResponse::kFront:
      return crc_of(part.front().points());
    case v1::MeasureTradeoffResponse::PART_NOT_SET:
      break;
  }
  return crc_of();
}

}  // namespace stiefel::wire
