// CRC-32C and the checksum of each message, against the definition bit by bit.
#include "proto/checksum/checksum.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "proto/checksum/crc32c.h"

namespace stiefel::wire {
namespace {

std::uint32_t bit_by_bit(std::string_view bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0x82f63b78 : 0);
  }
  return ~crc;
}

TEST(Crc32c, IsThatOfRfc3720) {
  std::string ascending, descending;
  for (int i = 0; i < 32; ++i) ascending += static_cast<char>(i);
  descending.assign(ascending.rbegin(), ascending.rend());
  for (const auto& [bytes, expected] : {std::pair{std::string(32, '\0'), 0x8a9136aau},
                                        {std::string(32, '\xff'), 0x62a8ab43u},
                                        {ascending, 0x46dd794eu},
                                        {descending, 0x113fdb5cu},
                                        {std::string("123456789"), 0xe3069283u},
                                        {std::string(), 0u}}) {
    EXPECT_EQ(crc32c(bytes), expected);
    EXPECT_EQ(crc32c_by_tables(bytes), expected);
  }
}

TEST(Crc32c, OfAnyLengthAndInPieces) {
  std::mt19937 random(1);
  std::string bytes;
  for (std::size_t size = 0; size < 100; ++size) {
    const std::uint32_t expected = bit_by_bit(bytes);
    for (std::size_t cut = 0; cut <= size; cut += 7) {
      const std::string_view all = bytes;
      EXPECT_EQ(crc32c(all.substr(cut), crc32c(all.substr(0, cut))), expected)
          << size << ' ' << cut;
      EXPECT_EQ(crc32c_by_tables(all.substr(cut), crc32c_by_tables(all.substr(0, cut))), expected);
    }
    bytes += static_cast<char>(random());
  }
}

/// The bytes of numbers, one after another.
template <class... Numbers>
std::string bytes(Numbers... numbers) {
  std::string all;
  (all.append(reinterpret_cast<const char*>(&numbers), sizeof numbers), ...);
  return all;
}

v1::Field field(double number) {
  v1::Field field;
  field.mutable_value()->set_data(bytes(number));
  return field;
}

/// Its numbers are 1 to 11 in the order of the checksum.
v1::Scene scene() {
  v1::Scene scene;
  scene.add_inertia(1);
  scene.add_inertia(2);
  scene.add_inertia_u(3);
  scene.add_inertia_v(4);
  scene.mutable_body()->add_inertia_tensor(5);
  scene.mutable_body()->add_moments(6);
  scene.mutable_body()->add_attitude(7);
  scene.mutable_body()->add_angular_velocity(8);
  (*scene.mutable_initial())["b"].add_values(11);
  (*scene.mutable_initial())["a"].add_values(9);
  (*scene.mutable_initial())["a"].add_imaginary(10);
  return scene;
}

std::string bytes_of_scene() {
  std::string all;
  for (int i = 1; i <= 11; ++i) all += bytes(static_cast<double>(i));
  return all;
}

TEST(Checksum, OfASampleAndOfABatch) {
  v1::Sample sample;
  sample.set_step(3);
  sample.set_time(0.25);
  *sample.add_fields() = field(7);
  *sample.add_fields() = field(8);
  EXPECT_EQ(checksum(sample), bit_by_bit(bytes(std::int64_t{3}, 0.25, 7.0, 8.0)));

  v1::StreamResponse batch;
  for (const int step : {3, 4}) {
    batch.add_steps(step);
    batch.add_times(step / 4.0);
  }
  *batch.add_fields() = field(7);
  *batch.add_scene_arrays() = field(8);
  batch.mutable_checkpoint()->set_data("bytes");
  EXPECT_EQ(checksum(batch),
            bit_by_bit(bytes(std::int64_t{3}, std::int64_t{4}, 0.75, 1.0, 7.0, 8.0) + "bytes"));
}

TEST(Checksum, OfADiagnosis) {
  v1::DiagnoseResponse diagnosis;
  diagnosis.set_step(3);
  diagnosis.set_time(0.25);
  for (const double first : {1.0, 5.0}) {
    auto& invariant = *diagnosis.add_invariants();
    invariant.set_initial(first);
    invariant.set_value(first + 1);
    invariant.set_drift(first + 2);
    invariant.set_scale(first + 3);
  }
  EXPECT_EQ(checksum(diagnosis),
            bit_by_bit(bytes(std::int64_t{3}, 0.25, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0)));
}

TEST(Checksum, OfTheDetailsOfADiagnosis) {
  v1::DiagnoseResponse diagnosis;
  EXPECT_EQ(details_checksum(diagnosis), 0u);
  diagnosis.mutable_domain()->set_h_omega(4);
  diagnosis.mutable_estimated_error()->set_reference_error(13);
  EXPECT_EQ(details_checksum(diagnosis), bit_by_bit(bytes(4.0, 13.0, 0.0, 0.0)));

  diagnosis.add_invariants()->set_member(1);
  diagnosis.add_invariants();
  diagnosis.add_invariants()->set_member(2);
  diagnosis.set_orthogonality(3);
  diagnosis.mutable_domain()->set_largest_step(5);
  diagnosis.add_forms(6);
  diagnosis.add_forms(7);
  diagnosis.add_dirac_brackets(8);
  diagnosis.set_symplectic_defect(9);
  v1::EstimatedError& error = *diagnosis.mutable_estimated_error();
  error.set_attitude(10);
  error.set_momentum(11);
  error.set_angle(12);
  error.set_work(14);
  error.set_run_work(15);
  error.set_member(16);
  EXPECT_EQ(details_checksum(diagnosis),
            bit_by_bit(bytes(1u, 2u, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0,
                             14.0, 15.0, 16u)));
}

TEST(Checksum, OfTheSetupOfATradeoff) {
  v1::MeasureTradeoffResponse part;
  v1::TradeoffSetup& setup = *part.mutable_setup();
  setup.set_reference_error(1);
  setup.set_horizon(2);
  setup.set_steps(3);
  setup.set_reference_steps(4);
  setup.set_budget(5);
  setup.set_repeats(6);
  setup.set_curves(7);
  EXPECT_EQ(checksum(part),
            bit_by_bit(bytes(1.0, 2.0, std::int64_t{3}, std::int64_t{4}, 5.0, 6u, 7u)));
}

TEST(Checksum, OfAPointAndTheFrontOfATradeoff) {
  v1::MeasureTradeoffResponse part;
  v1::TradeoffPoint& point = *part.mutable_point();
  point.set_drift(6);
  point.set_work(7);
  point.add_cpu_seconds_per_second(8);
  point.add_cpu_seconds_per_second(9);
  point.set_steps_per_second(10);
  point.set_measured_steps(11);
  EXPECT_EQ(checksum(part), bit_by_bit(bytes(6.0, 7.0, 8.0, 9.0, 10.0, std::int64_t{11})));
  point.mutable_method()->set_order(1);
  point.mutable_method()->set_substeps(2);
  point.mutable_method()->set_tolerance(3);
  point.set_attitude_error(4);
  point.set_momentum_error(5);
  EXPECT_EQ(checksum(part),
            bit_by_bit(bytes(1u, 2u, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, std::int64_t{11})));

  part.mutable_front()->add_points(5);
  part.mutable_front()->add_points(0);
  EXPECT_EQ(checksum(part), bit_by_bit(bytes(5u, 0u)));
}

TEST(Checksum, OfScenes) {
  v1::Session session;
  *session.mutable_scene() = scene();
  EXPECT_EQ(checksum(session), bit_by_bit(bytes_of_scene()));

  v1::ConvertResponse conversion;
  *conversion.mutable_scene() = scene();
  *conversion.add_blocks() = field(13);
  *conversion.add_scene_arrays() = field(12);
  EXPECT_EQ(checksum(conversion), bit_by_bit(bytes_of_scene() + bytes(12.0, 13.0)));

  v1::ConnectResponse geodesic;
  *geodesic.mutable_scene() = scene();
  *geodesic.mutable_trajectory() = field(12);
  EXPECT_EQ(checksum(geodesic), bit_by_bit(bytes_of_scene() + bytes(12.0)));
}

}  // namespace
}  // namespace stiefel::wire
