#include "stiefel/client/client.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/cpp/channel.h"
#include "client/cpp/uuid.h"

namespace stiefel::client {
namespace {

/// Deletes a session from the server when it is destroyed.
struct Deletion {
  explicit Deletion(std::shared_ptr<const Connection> shared) : connection(std::move(shared)) {}
  Deletion(const Deletion&) = delete;
  ~Deletion() {
    // Not a Context: a stop request does not keep the session on the server.
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(5));
    context.AddMetadata("stiefel-session", request.session_id());
    v1::DeleteSessionResponse reply;
    connection->stub->DeleteSession(&context, request, &reply);
  }

  std::shared_ptr<const Connection> connection;
  v1::DeleteSessionRequest request;
};

}  // namespace

Client Client::connect(const std::string& address, Options options) {
  auto stub = v1::SimulationService::NewStub(make_channel(address, options));
  return Client(std::make_shared<const Connection>(std::move(stub), std::move(options), address));
}

Client::Client(std::shared_ptr<grpc::Channel> channel, Options options)
    : Client(std::make_shared<const Connection>(v1::SimulationService::NewStub(channel),
                                                std::move(options))) {}

v1::DescribeResponse Client::describe() const {
  return call(&Stub::Describe, v1::DescribeRequest());
}

Session Client::create(const v1::Scene& scene, const std::string& id) const {
  v1::CreateSessionRequest request;
  request.set_session_id(id);
  *request.mutable_scene() = scene;
  return create(std::move(request));
}

Session Client::create(v1::CreateSessionRequest request) const {
  if (request.session_id().empty()) request.set_session_id(make_uuid());
  request.set_return_scene(true);
  auto reply = call(&Stub::CreateSession, request);
  return Session(connection_, std::move(*reply.mutable_session()));
}

Session Client::temporary(const v1::Scene& scene) const {
  const Session session = create(scene);
  auto deletion = std::make_shared<Deletion>(connection_);
  deletion->request.set_session_id(session.id());
  const Connection* connection = connection_.get();
  return Session({std::move(deletion), connection}, session.description());
}

Session Client::get(const std::string& id) const {
  v1::GetSessionRequest request;
  request.set_session_id(id);
  request.set_return_scene(true);
  auto reply = call(&Stub::GetSession, request);
  return Session(connection_, std::move(*reply.mutable_session()));
}

std::vector<v1::Session> Client::list() const {
  std::vector<v1::Session> sessions;
  v1::ListSessionsRequest request;
  do {
    auto reply = call(&Stub::ListSessions, request);
    std::ranges::move(*reply.mutable_sessions(), std::back_inserter(sessions));
    request.set_page_token(reply.next_page_token());
  } while (!request.page_token().empty());
  return sessions;
}

void Client::remove(const std::string& id) const {
  v1::DeleteSessionRequest request;
  request.set_session_id(id);
  call(&Stub::DeleteSession, request);
}

std::vector<v1::ConnectResponse> Client::geodesics(const v1::ConnectRequest& request) const {
  std::vector<v1::ConnectResponse> geodesics;
  for (v1::ConnectResponse& reply : call(&Stub::Connect, request))
    geodesics.push_back(std::move(reply));
  if (std::cmp_not_equal(geodesics.size(), request.pairs_size()))
    throw Error({grpc::StatusCode::DATA_LOSS, "the server answered " +
                                                  std::to_string(geodesics.size()) + " of " +
                                                  std::to_string(request.pairs_size()) + " pairs"});
  std::ranges::sort(geodesics, {}, &v1::ConnectResponse::pair);
  return geodesics;
}

}  // namespace stiefel::client
