#include "server/convert/linearize.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

/// Returns the numbers of the state's blocks.
std::int64_t state_size(const Session& session) {
  std::int64_t size = 0;
  for (const auto& [name, matrix] : session.scene().description().initial)
    size += static_cast<std::int64_t>(matrix.values.size() + matrix.imaginary.size());
  constexpr std::int64_t of_body = 18;  // Q and M of a scene with `body`
  return std::max(size, of_body);
}

std::int64_t steps_of(const v1::LinearizeRequest& request, std::int64_t start) {
  return request.to() - std::min(start, request.from());
}

std::uint64_t results_of(const v1::LinearizeRequest& request) {
  const std::int64_t every = request.every();
  return every > 0 ? static_cast<std::uint64_t>((request.to() - request.from()) / every) + 2 : 1;
}

/// Whether coordinates are offered for the state. Where they are not, a call that needs them is
/// refused when it begins, so that they have no price.
bool has_coordinates(const Session& session) {
  return state_size(session) <= Linearization::largest_in_coordinates;
}

std::uint64_t result_bytes(const Session& session, const v1::LinearizeRequest& request) {
  const auto size = static_cast<std::uint64_t>(state_size(session));
  return sizeof(double) * size *
         (static_cast<std::uint64_t>(most_vectors(session, request)) +
          (request.bases() && has_coordinates(session) ? 2 * size : 0));
}

/// Returns a tensor of the numbers of V; each column is a tensor of this shape.
v1::Field field_of(const char* name, const Eigen::MatrixXd& V, Eigen::Index rows,
                   Eigen::Index cols) {
  v1::Field field;
  field.set_name(name);
  v1::Tensor& tensor = *field.mutable_value();
  tensor.set_data_type(v1::DATA_TYPE_FLOAT64);
  for (const Eigen::Index size : {V.cols(), rows, cols})
    tensor.add_shape(static_cast<std::uint64_t>(size));
  tensor.mutable_data()->assign(reinterpret_cast<const char*>(V.data()),
                                static_cast<std::size_t>(V.size()) * sizeof(double));
  return field;
}
v1::Field matrix_field(const Eigen::MatrixXd& values) {
  const RowMatrix by_rows = values;
  v1::Field field;
  field.set_name("matrix");
  v1::Tensor& tensor = *field.mutable_value();
  tensor.set_data_type(v1::DATA_TYPE_FLOAT64);
  tensor.add_shape(static_cast<std::uint64_t>(values.rows()));
  tensor.add_shape(static_cast<std::uint64_t>(values.cols()));
  tensor.mutable_data()->assign(reinterpret_cast<const char*>(by_rows.data()),
                                static_cast<std::size_t>(by_rows.size()) * sizeof(double));
  return field;
}

/// Reads the vectors, one a column.
OrStatus<LinearizationDescription> read(const v1::LinearizeRequest& request) {
  LinearizationDescription out;
  out.by_inertia = request.inertia();
  out.by_step = request.step();
  if (!request.has_vectors()) return out;
  const v1::Tensor& given = request.vectors();
  const auto refuse = [](std::string value, std::string rule) {
    return std::unexpected(errors::invalid("vectors", std::move(value), std::move(rule)));
  };
  const int axes = given.shape_size();
  if (axes != 2 && axes != 3)
    return refuse(std::to_string(axes) + " axes", "must have the shape (m, d) or (m, rows, cols)");
  if (given.data_type() != v1::DATA_TYPE_FLOAT64)
    return refuse(v1::DataType_Name(given.data_type()), "must be DATA_TYPE_FLOAT64");
  const std::uint64_t numbers = given.data().size() / sizeof(double);
  std::uint64_t each = 1;
  for (int axis = 1; axis < axes; ++axis) {
    each *= given.shape(axis);
    if (given.shape(axis) > numbers || each > numbers)
      return refuse(std::to_string(given.data().size()) + " bytes", "must fill the shape");
  }
  const std::uint64_t count = given.shape(0);
  if (count < 1 || each < 1 || count > numbers ||
      count * each * sizeof(double) != given.data().size())
    return refuse(std::to_string(given.data().size()) + " bytes",
                  "must fill the shape, with at least one vector");
  Eigen::MatrixXd V(static_cast<Eigen::Index>(each), static_cast<Eigen::Index>(count));
  std::memcpy(V.data(), given.data().data(), given.data().size());
  out.vectors = std::move(V);
  out.as_blocks = axes == 3;
  return out;
}

void put(const Eigen::VectorXd& numbers, google::protobuf::RepeatedField<double>* out) {
  out->Assign(numbers.begin(), numbers.end());
}

v1::Verdict verdict_of(MotionKind kind) {
  switch (kind) {
    case MotionKind::regular:
      return v1::VERDICT_REGULAR;
    case MotionKind::chaotic:
      return v1::VERDICT_CHAOTIC;
    case MotionKind::undecided:
      break;
  }
  return v1::VERDICT_UNDECIDED;
}

}  // namespace

std::int64_t most_vectors(const Session& session, const v1::LinearizeRequest& request) {
  const bool given = request.has_vectors() && request.vectors().shape_size() > 0;
  if (!given && !has_coordinates(session)) return 0;
  const std::int64_t first =
      given ? static_cast<std::int64_t>(
                  std::min<std::uint64_t>(request.vectors().shape(0), request.ByteSizeLong()))
            : state_size(session);
  return first + (request.inertia() ? session.scene().dimension() : 0) + (request.step() ? 1 : 0);
}

double work_of_vectors(const Session& session, const v1::LinearizeRequest& request) {
  return linearization_work(session.scene(), session.most_work(0, 1),
                            most_vectors(session, request));
}

double linearize_work(const Session& session, const v1::LinearizeRequest& request,
                      std::int64_t start) {
  const auto results = static_cast<std::int64_t>(results_of(request));
  const double steps = session.most_work(start, request.to(), results);
  const std::int64_t count = steps_of(request, start);
  if (count < 1) return steps;
  const double moved =
      static_cast<double>(session.direct() ? results : request.to() - request.from());
  const auto size =
      static_cast<double>(std::min(state_size(session), Linearization::largest_in_coordinates));
  return steps + moved * work_of_vectors(session, request) +
         static_cast<double>(results + 1) * 12 * size * size * size;
}

std::uint64_t linearize_workspace(const Session& session, const v1::LinearizeRequest& request) {
  return session.simulation_bytes() +
         linearization_bytes(session.scene(), most_vectors(session, request),
                             request.vectors().shape_size() != 3 || request.bases()) +
         2 * result_bytes(session, request);
}

LinearizeAnswer::~LinearizeAnswer() {
  if (simulation_) session_->give_back(std::move(simulation_));
}

grpc::Status LinearizeAnswer::make() {
  simulation_ = session_->lease(request_.from());
  return grpc::Status::OK;
}

grpc::Status LinearizeAnswer::begin() {
  auto what = read(request_);
  if (!what) return what.error();
  auto made = Linearization::make(session_->scene(), *std::move(what), *simulation_);
  if (!made) return errors::invalid(made.error());
  if (request_.bases() && !has_coordinates(*session_))
    return errors::invalid("bases", "true",
                           "must be false: coordinates are offered for states of up to " +
                               std::to_string(Linearization::largest_in_coordinates) + " numbers");
  linearization_.emplace(*std::move(made));
  if (request_.bases())
    parts_.add(field_of("start_basis", linearization_->basis(*simulation_), linearization_->rows(),
                        linearization_->cols()));
  at_result_ = request_.every() > 0 || request_.from() == request_.to();
  if (at_result_) add_result();
  return grpc::Status::OK;
}

std::int64_t LinearizeAnswer::next_result() const {
  if (request_.every() < 1) return request_.to();
  const std::int64_t done = simulation_->step() - request_.from();
  return std::min(request_.to(),
                  request_.from() + (done / request_.every() + 1) * request_.every());
}

grpc::Status LinearizeAnswer::advance(std::int64_t steps, const std::stop_token& stop) {
  if (!linearization_) {
    if (simulation_->step() == request_.from()) return begin();
    const std::int64_t left = request_.from() - simulation_->step();
    const std::int64_t before = simulation_->step();
    status_ = simulation_->advance(session_->direct() ? left : std::min(steps, left), stop);
    computed_ += session_->direct() ? 1 : simulation_->step() - before;
  } else {
    const std::int64_t left = next_result() - simulation_->step(), before = simulation_->step();
    status_ = linearization_->advance(*simulation_,
                                      session_->direct() ? left : std::min(steps, left), stop);
    computed_ += session_->direct() ? 1 : simulation_->step() - before;
    at_result_ =
        !status_.reached() || simulation_->step() == request_.to() ||
        (request_.every() > 0 && (simulation_->step() - request_.from()) % request_.every() == 0);
    if (status_.outcome == Outcome::cancelled) return errors::cancelled();
    if (at_result_) add_result();
  }
  if (status_.outcome == Outcome::cancelled) return errors::cancelled();
  if (!status_.reached()) at_result_ = true;
  return grpc::Status::OK;
}

void LinearizeAnswer::add_result() {
  if (!linearization_) return;
  const Eigen::MatrixXd V = linearization_->vectors(*simulation_);
  finite_ = finite_ && V.allFinite();
  const bool blocks = request_.vectors().shape_size() == 3;
  parts_.add(blocks ? field_of("vectors", V, linearization_->rows(), linearization_->cols())
                    : matrix_field(V));
  if (request_.bases())
    parts_.add(field_of("basis", linearization_->basis(*simulation_), linearization_->rows(),
                        linearization_->cols()));
}

bool LinearizeAnswer::next(v1::LinearizeResponse& message) {
  message.Clear();
  message.set_step(simulation_->step());
  message.set_time(session_->scene().time(simulation_->step()));
  if (!parts_.empty()) parts_.take(part_bytes, message.mutable_fields());
  message.set_result_continues(!parts_.empty() || !at_result_);
  message.set_computed_steps(computed_);
  if (!std::exchange(priced_, true))
    to_proto(work_, result_bytes(*session_, request_) * results_of(request_),
             bound_of_steps(*session_), session_->simulation_bytes() + memory_,
             message.mutable_price());
  if (!parts_.empty()) return false;
  at_result_ = false;
  const bool last = !status_.reached() || simulation_->step() >= request_.to();
  if (last) {
    to_proto(status_, message.mutable_run_status());
    demand_finite(finite_, message.mutable_run_status());
  }
  return last;
}

LyapunovPrice lyapunov_price(const Session& session, const v1::LyapunovSpectrumRequest& request) {
  const std::int64_t size = state_size(session);
  const LyapunovDescription what{
      .count = request.count(),
      .orthonormalization = request.orthonormalization() == v1::ORTHONORMALIZATION_CONTINUOUS
                                ? Orthonormalization::continuous
                                : Orthonormalization::discrete_qr};
  const auto vectors = std::min(lyapunov_vectors(what, size), size);
  const double step = session.most_work(0, 1);
  const auto steps = static_cast<double>(request.to() - request.from());
  LyapunovPrice price;
  price.of_step = lyapunov_work(session.scene(), step, vectors, size);
  const std::int64_t start = session.start_for(request.from());
  // A second motion, where there is one, has twice as many substeps.
  const double beside = 2 * step + lyapunov_work(session.scene(), 2 * step, 1, size);
  price.total = session.most_work(start, request.to()) + steps * price.of_step +
                most_steps_beside * steps * beside;
  price.bytes = session.simulation_bytes() + lyapunov_bytes(session.scene(), what, size);
  return price;
}

LyapunovAnswer::~LyapunovAnswer() {
  if (simulation_) session_->give_back(std::move(simulation_));
}

grpc::Status LyapunovAnswer::read() {
  if (!v1::Orthonormalization_IsValid(request_.orthonormalization()))
    return errors::invalid("orthonormalization", std::to_string(request_.orthonormalization()),
                           "must be DISCRETE_QR or CONTINUOUS");
  what_ = {.from = request_.from(),
           .to = request_.to(),
           .count = request_.count(),
           .orthonormalization = request_.orthonormalization() == v1::ORTHONORMALIZATION_CONTINUOUS
                                     ? Orthonormalization::continuous
                                     : Orthonormalization::discrete_qr,
           .interval = request_.interval(),
           .seed = request_.seed()};
  start_ = what_.from;
  if (request_.checkpoint().empty()) return grpc::Status::OK;
  const auto content = verify_checkpoint(*session_, growth_format, request_.checkpoint());
  if (content) {
    saved_ = *content;
    start_ = LyapunovExponents::saved_step(saved_);
    if (start_ >= what_.from && start_ <= what_.to) return grpc::Status::OK;
    return errors::invalid("checkpoint", "step " + std::to_string(start_),
                           "must be of a step between `from` and `to`");
  }
  ignored_ = content.error().fault == CheckpointFault::foreign;
  if (ignored_) return grpc::Status::OK;
  if (content.error().fault == CheckpointFault::other_numerics)
    return errors::checkpoint_of_other_numerics(content.error().numerics_id, numerics_id());
  return errors::invalid("checkpoint", std::to_string(request_.checkpoint().size()) + " bytes",
                         content.error().fault == CheckpointFault::other_scene
                             ? "must come from a session of the same scene"
                             : "is damaged: must be the bytes that LyapunovSpectrum returned");
}

grpc::Status LyapunovAnswer::make() {
  if (auto status = read(); !status.ok()) return status;
  simulation_ = session_->lease(start_);
  return grpc::Status::OK;
}

grpc::Status LyapunovAnswer::begin() {
  auto made = saved_.empty()
                  ? LyapunovExponents::make(session_->scene(), what_, *simulation_)
                  : LyapunovExponents::resume(session_->scene(), what_, saved_, *simulation_);
  if (!made) return errors::invalid(made.error());
  spectrum_.emplace(*std::move(made));
  const std::int64_t every = request_.every();
  mark_ = every > 0 ? what_.from + ((start_ - what_.from) / every + 1) * every : what_.to;
  checkpoint_step_ = start_;
  return grpc::Status::OK;
}

std::int64_t LyapunovAnswer::steps_between_checkpoints() const {
  constexpr double most = 64;
  constexpr double least_work = 1e10;
  if (work_ < least_work) return std::numeric_limits<std::int64_t>::max();
  const double part = std::max(1. / most, least_work / work_);
  return static_cast<std::int64_t>(part * static_cast<double>(what_.to - what_.from)) + 1;
}

void LyapunovAnswer::take_checkpoint() {
  const std::string content = spectrum_->save();
  checkpoint_ = sign_checkpoint(*session_, growth_format, {content});
  checkpoint_step_ = LyapunovExponents::saved_step(content);
  sent_ = 0;
}

grpc::Status LyapunovAnswer::advance(std::int64_t steps, const std::stop_token& stop) {
  if (!spectrum_) {
    if (simulation_->step() == start_) return begin();
    const std::int64_t left = start_ - simulation_->step(), before = simulation_->step();
    status_ = simulation_->advance(session_->direct() ? left : std::min(steps, left), stop);
    computed_ += session_->direct() ? 1 : simulation_->step() - before;
    ended_ = !status_.reached();
  } else if (!spectrum_->done()) {
    // The end of the interval in which the mark is.
    const std::int64_t interval = spectrum_->interval();
    const std::int64_t end = what_.from + ((mark_ - what_.from - 1) / interval + 1) * interval;
    const bool before = simulation_->step() < std::min(end, what_.to);
    status_ = spectrum_->advance(*simulation_,
                                 before ? std::min(steps, end - simulation_->step()) : steps, stop);
    ended_ = !status_.reached();
    if (before && spectrum_->step() == end && end < what_.to) {
      due_ = true;
      mark_ += ((end - mark_) / request_.every() + 1) * request_.every();
    }
  }
  if (status_.outcome == Outcome::cancelled) return errors::cancelled();
  if (spectrum_ && spectrum_->done()) ended_ = true;
  if (spectrum_ &&
      (ended_ || spectrum_->step() - checkpoint_step_ >= steps_between_checkpoints()))
    take_checkpoint();
  return grpc::Status::OK;
}

bool LyapunovAnswer::next(v1::LyapunovSpectrumResponse& message) {
  message.Clear();
  const bool due = std::exchange(due_, false);
  const std::int64_t step = spectrum_ ? spectrum_->step() : simulation_->step();
  message.set_step(step);
  message.set_time(session_->scene().time(step));
  message.set_computed_steps(computed_steps());
  if (!std::exchange(priced_, true)) {
    to_proto(work_, checkpoint_.size(), v1::PRICE_BOUND_AT_MOST,
             session_->simulation_bytes() + memory_, message.mutable_price());
    message.set_checkpoint_ignored(ignored_);
  }
  if (spectrum_) message.set_interval(spectrum_->interval());
  if (sent_ < checkpoint_.size()) {
    auto& part = *message.mutable_checkpoint();
    part.set_step(checkpoint_step_);
    part.set_size(checkpoint_.size());
    part.set_offset(sent_);
    part.set_data(checkpoint_.substr(sent_, part_bytes));
    sent_ += part.data().size();
  }
  const bool last = ended_ && sent_ == checkpoint_.size();
  const bool has_numbers = spectrum_ && spectrum_->step() > what_.from;
  if (has_numbers && (last || due)) {
    put(spectrum_->exponents(), message.mutable_exponents());
    put(spectrum_->log_gali(), message.mutable_log_gali());
  }
  if (!last) return false;
  if (has_numbers) {
    const Eigen::VectorXd errors = spectrum_->errors();
    if (errors.allFinite()) put(errors, message.mutable_errors());
  }
  message.set_verdict(spectrum_ ? verdict_of(spectrum_->kind()) : v1::VERDICT_UNDECIDED);
  message.set_reason(spectrum_ ? spectrum_->reason()
                               : "The motion ended before the vectors started.");
  to_proto(status_, message.mutable_run_status());
  return true;
}

}  // namespace stiefel::server
