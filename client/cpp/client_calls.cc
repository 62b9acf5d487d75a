#include "stiefel/client/client.h"

#include <utility>

#include "client/cpp/assembly.h"
#include "client/cpp/channel.h"
#include "client/cpp/replies.h"
#include "client/cpp/resolved_scene.h"
#include "client/cpp/uuid.h"

namespace stiefel::client {

using Stub = v1::SimulationService::Stub;

Client Client::connect(const std::string& address, Options options) {
  if (const auto fault = fault_of_address(address))
    throw Error(grpc::StatusCode::INVALID_ARGUMENT, "cannot reach " + address + ": " + *fault);
  auto channel = make_channel(address, options.security);
  return Client(Connection{v1::SimulationService::NewStub(channel), options, channel, address});
}

Client::Client(std::shared_ptr<grpc::Channel> channel, Options options)
    : Client(Connection{v1::SimulationService::NewStub(channel), options}) {}

Client::Client(Connection connection)
    : connection_(std::make_shared<const Connection>(std::move(connection))) {}

v1::DescribeResponse Client::describe() const {
  auto reply =
      connection_->call(&Stub::Describe, v1::DescribeRequest(), connection_->options.timeout);
  check_present(reply, {"version", "numerics_id", "build", "limits", "systems", "methods"});
  return reply;
}

Session Client::create(const v1::Scene& scene, std::string id, std::string checkpoint) const {
  v1::CreateSessionRequest request;
  request.set_session_id(id.empty() ? make_uuid() : std::move(id));
  *request.mutable_scene() = scene;
  request.set_checkpoint(std::move(checkpoint));
  Recreation routed(connection_, request.session_id());
  auto reply =
      connection_->call(&Stub::CreateSession, request, connection_->options.timeout, &routed);
  check_session(reply.session(), request.session_id(), true);
  return Session(connection_, std::move(*reply.mutable_session()), scene, false,
                 std::move(*request.mutable_checkpoint()));
}

Session Client::attach(const std::string& id) const {
  v1::GetSessionRequest request;
  request.set_session_id(id);
  request.mutable_view()->set_scene(v1::SCENE_VIEW_FULL);
  Recreation routed(connection_, id);
  auto reply = connection_->call(&Stub::GetSession, request, connection_->options.timeout, &routed);
  check_session(reply.session(), id, true);
  return Session(connection_, std::move(*reply.mutable_session()), {}, true);
}

std::vector<v1::Session> Client::list() const {
  std::vector<v1::Session> sessions;
  v1::ListSessionsRequest request;
  do {
    auto reply = connection_->call(&Stub::ListSessions, request, connection_->options.timeout);
    for (auto& session : *reply.mutable_sessions()) {
      check_session(session, session.session_id(), false);
      require(sessions.empty() || sessions.back().session_id() < session.session_id(),
              "the sessions are not in the order of their ids");
      sessions.push_back(std::move(session));
    }
    request.set_page_token(reply.next_page_token());
    require(request.page_token().empty() || !reply.sessions().empty(),
            "a page without sessions is not the last");
  } while (!request.page_token().empty());
  return sessions;
}

void Client::remove(const std::string& id) const {
  v1::DeleteSessionRequest request;
  request.set_session_id(id);
  Recreation routed(connection_, id);
  connection_->call(&Stub::DeleteSession, request, connection_->options.timeout, &routed);
}

v1::ConvertResponse Client::convert(v1::ConvertRequest request) const {
  request.set_view(v1::SCENE_VIEW_FILLED_IN);
  auto replies = connection_->call_all(&Stub::Convert, request, connection_->options.timeout);
  Assembly blocks, scene_arrays;
  for (auto& reply : replies) {
    require(reply.continues() == (&reply != &replies.back()),
            "a part of the conversion is missing");
    blocks.take(reply.mutable_blocks());
    scene_arrays.take(reply.mutable_scene_arrays());
  }
  v1::ConvertResponse whole = std::move(replies.front());
  whole.clear_continues();
  *whole.mutable_blocks() = blocks.finish();
  check_present(whole, {"price"});
  require(whole.has_scene() == whole.blocks().empty(), "a conversion has a scene or blocks");
  check_blocks(whole.scene());
  for (const auto& block : whole.blocks())
    require(block.value().data_type() != v1::DATA_TYPE_INT64, "a block has counts");
  if (!whole.has_scene()) return whole;
  Names left_out;
  const Fields arrays = scene_arrays.finish();
  for (const auto& array : arrays) *left_out.Add() = array.name();
  *whole.mutable_scene() =
      resolved_scene(std::move(*request.mutable_scene()), whole.scene(), whole.cleared(), left_out);
  for (const auto& array : arrays) set_array(array, whole.mutable_scene());
  return whole;
}

v1::ConjugatePointsResponse Client::conjugate_points(
    const v1::ConjugatePointsRequest& request) const {
  auto replies =
      connection_->call_all(&Stub::ConjugatePoints, request, connection_->options.compute_timeout);
  v1::ConjugatePointsResponse whole = std::move(replies.front());
  for (const auto& reply : replies) {
    require((&reply == &replies.front() ? whole : reply).continues() == (&reply != &replies.back()),
            "a part of the points is missing");
    if (&reply != &replies.front()) whole.mutable_points()->MergeFrom(reply.points());
  }
  whole.clear_continues();
  check_present(whole, {"run_status", "price"});
  check_outcome(whole.run_status());
  require(whole.has_radius() == request.has_radius(), "a radius is not what was asked for");
  for (const auto& point : whole.points())
    require(std::cmp_equal(point.kernel_size(), point.multiplicity()),
            "a kernel has another dimension");
  return whole;
}

std::vector<v1::ConnectResponse> Client::geodesics(v1::ConnectRequest request) const {
  auto replies =
      connection_->call_all(&Stub::Connect, request, connection_->options.compute_timeout);
  std::vector<v1::ConnectResponse> geodesics;
  std::vector<Assembly> arrays;
  for (auto& reply : replies) {
    if (geodesics.empty() || geodesics.back().pair() != reply.pair()) {
      geodesics.push_back(reply);
      geodesics.back().clear_scene_arrays();
      arrays.emplace_back();
    }
    if (reply.has_velocity()) arrays.back().take(reply.mutable_velocity());
    for (auto& part : *reply.mutable_scene_arrays()) arrays.back().take(&part);
    if (reply.has_trajectory()) arrays.back().take(reply.mutable_trajectory());
  }
  for (std::size_t i = 0; i < geodesics.size(); ++i) {
    for (auto& whole : arrays[i].finish()) {
      if (whole.name() == "Q")
        *geodesics[i].mutable_trajectory() = std::move(whole);
      else if (whole.name() == "Qdot")
        *geodesics[i].mutable_velocity() = std::move(whole);
      else
        set_array(whole, geodesics[i].mutable_scene());
    }
  }
  std::ranges::sort(geodesics, {}, &v1::ConnectResponse::pair);
  for (std::size_t i = 0; i < geodesics.size(); ++i) {
    require(geodesics[i].pair() == i && std::cmp_less(i, request.pairs_size()),
            "a pair is missing");
    check_geodesic(geodesics[i], request);
  }
  if (std::cmp_not_equal(geodesics.size(), request.pairs_size()))
    throw CorruptReply("the server answered " + std::to_string(geodesics.size()) + " of " +
                       std::to_string(request.pairs_size()) + " pairs");
  return geodesics;
}

void Client::tradeoff(v1::MeasureTradeoffRequest request, const TradeoffReceiver& receive) const {
  const Deadline deadline(connection_->options.compute_timeout);
  for (auto waiting = connection_->patience(deadline);;) {
    grpc::ClientContext context;
    deadline.limit(context);
    const CancelOnStop cancel(connection_->options.stop, context);
    const auto reader = connection_->stub->MeasureTradeoff(&context, request);
    v1::MeasureTradeoffResponse part;
    TradeoffParts parts;
    bool wanted = true;
    while (wanted && reader->Read(&part)) {
      parts.check(part);
      wanted = receive(part);
    }
    if (!wanted) {
      context.TryCancel();
      reader->Finish();
      return;
    }
    const grpc::Status status = finish(context, *reader);
    if (status.ok()) return parts.end();
    // Once parts have arrived, a retry would measure everything again, with other times.
    if (parts.begun() || !waiting.allows_another(status)) throw connection_->error(status, context);
  }
}

}  // namespace stiefel::client
