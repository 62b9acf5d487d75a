#include "server/convert/tangents/linearize_answer.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

/// Whether coordinates are offered for the state. Where they are not, a call that needs them is
/// refused when it begins, so that they take no bytes.
bool has_coordinates(const Session& session) {
  return state_size(session) <= Linearization::largest_in_coordinates;
}

/// Returns the most vectors that a Linearize moves: those of its request or, without, the numbers
/// of the state; and those of parameters.
std::int64_t most_vectors(const Session& session, const v1::LinearizeRequest& request) {
  const bool given = request.has_vectors() && request.vectors().shape_size() > 0;
  if (!given && !has_coordinates(session)) return 0;
  const std::int64_t first = given ? static_cast<std::int64_t>(std::min<std::uint64_t>(
                                         request.vectors().shape(0), request.ByteSizeLong()))
                                   : state_size(session);
  return first + (request.inertia() ? session.scene().dimension() : 0) + (request.step() ? 1 : 0);
}

std::uint64_t result_bytes(const Session& session, const v1::LinearizeRequest& request) {
  const auto size = static_cast<std::uint64_t>(state_size(session));
  return sizeof(double) * size *
         (static_cast<std::uint64_t>(most_vectors(session, request)) +
          (request.bases() && has_coordinates(session) ? 2 * size : 0));
}

/// Returns an array of the columns of V, each of this shape.
v1::Field field_of(const char* name, const Eigen::MatrixXd& V, Eigen::Index rows,
                   Eigen::Index cols) {
  return to_field(name, {V.cols(), rows, cols}, {V.data(), static_cast<std::size_t>(V.size())});
}

/// Reads the vectors, one a column.
LinearizationDescription read(const v1::LinearizeRequest& request) {
  LinearizationDescription out;
  out.by_inertia = request.inertia();
  out.by_step = request.step();
  if (!request.has_vectors()) return out;
  const v1::Tensor& given = request.vectors();
  const auto refuse = [](std::string value, std::string rule) {
    return errors::invalid("vectors", std::move(value), std::move(rule));
  };
  const int axes = given.shape_size();
  if (axes != 2 && axes != 3)
    throw refuse(std::to_string(axes) + " axes", "must have the shape (m, d) or (m, rows, cols)");
  if (given.data_type() != v1::DATA_TYPE_FLOAT64)
    throw refuse(v1::DataType_Name(given.data_type()), "must be DATA_TYPE_FLOAT64");
  const std::uint64_t bytes = given.data().size(), too_many = bytes / sizeof(double) + 1;
  std::uint64_t numbers = 1;  // of the shape; `too_many` for more than there are
  for (const std::uint64_t extent : given.shape())
    numbers = std::min(numbers * std::min(extent, too_many), too_many);
  if (numbers == 0 || numbers * sizeof(double) != bytes)
    throw refuse(std::to_string(bytes) + " bytes", "must fill the shape, with at least one vector");
  const auto count = static_cast<Eigen::Index>(given.shape(0));
  Eigen::MatrixXd V(static_cast<Eigen::Index>(numbers) / count, count);
  std::memcpy(V.data(), given.data().data(), bytes);
  out.vectors = std::move(V);
  out.as_blocks = axes == 3;
  return out;
}

}  // namespace

std::int64_t state_size(const Session& session) {
  std::int64_t size = 0;
  for (const auto& [name, matrix] : session.scene().description().initial)
    size += static_cast<std::int64_t>(matrix.values.size() + matrix.imaginary.size());
  constexpr std::int64_t of_body = 18;  // Q and M of a scene with `body`
  return std::max(size, of_body);
}

std::uint64_t tangent_workspace(const Session& session, const v1::LinearizeRequest& request) {
  const bool in_coordinates = request.vectors().shape_size() != 3 || request.bases();
  return session.simulation_bytes() +
         linearization_bytes(session.scene(), most_vectors(session, request), in_coordinates) +
         3 * result_bytes(session, request);
}

LinearizeAnswer::~LinearizeAnswer() {
  if (simulation_) session_->release(std::move(simulation_));
}

void LinearizeAnswer::begin() {
  auto made = value_of(Linearization::make(session_->scene(), read(request_), *simulation_));
  if (request_.bases() && !has_coordinates(*session_))
    throw errors::invalid("bases", "true",
                          "must be false: coordinates are offered for states of up to " +
                              std::to_string(Linearization::largest_in_coordinates) + " numbers");
  linearization_ = std::move(made);
  if (request_.bases())
    *fields_.Add() = field_of("start_basis", linearization_->start_basis(*simulation_),
                              linearization_->rows(), linearization_->cols());
  at_result_ = request_.every() > 0 || request_.from() == request_.to();
  if (at_result_) add_result();
}

std::int64_t LinearizeAnswer::next_result() const {
  if (request_.every() < 1) return request_.to();
  const std::int64_t done = simulation_->step() - request_.from();
  return std::min(request_.to(),
                  request_.from() + (done / request_.every() + 1) * request_.every());
}

void LinearizeAnswer::advance(std::int64_t steps, const std::stop_token& stop) {
  const std::int64_t before = simulation_->step();
  if (!linearization_ && before == request_.from()) return begin();
  const std::int64_t to = linearization_ ? next_result() : request_.from();
  const std::int64_t by = session_->direct() ? to - before : std::min(steps, to - before);
  status_ = linearization_ ? linearization_->advance(*simulation_, by, stop)
                           : simulation_->advance(by, stop);
  computed_ += session_->direct() ? 1 : simulation_->step() - before;
  if (status_.outcome == Outcome::cancelled) throw Stopped();
  at_result_ = !status_.reached() || (linearization_ && simulation_->step() == to);
  if (at_result_ && linearization_) add_result();
}

void LinearizeAnswer::add_result() {
  const Eigen::MatrixXd V = linearization_->vectors(*simulation_);
  finite_ = finite_ && V.allFinite();
  const bool blocks = request_.vectors().shape_size() == 3;
  *fields_.Add() = blocks ? field_of("vectors", V, linearization_->rows(), linearization_->cols())
                          : to_field("matrix", V);
  if (request_.bases())
    *fields_.Add() = field_of("basis", linearization_->basis(*simulation_), linearization_->rows(),
                              linearization_->cols());
}

bool LinearizeAnswer::next(v1::LinearizeResponse& message) {
  message.Clear();
  message.set_step(simulation_->step());
  message.set_time(session_->scene().time(simulation_->step()));
  message.mutable_fields()->Swap(&fields_);
  message.set_computed_steps(computed_);
  at_result_ = false;
  const bool last = !status_.reached() || simulation_->step() >= request_.to();
  if (last) {
    to_proto(status_, message.mutable_run_status());
    demand_finite(finite_, message.mutable_run_status());
  }
  return last;
}

}  // namespace stiefel::server
