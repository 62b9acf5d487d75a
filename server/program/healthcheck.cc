#include "server/program/healthcheck.h"

#include <google/protobuf/wrappers.pb.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/impl/codegen/proto_utils.h>

#include <chrono>
#include <future>
#include <iostream>
#include <utility>

#include "server/connections/listener.h"

namespace stiefel::server {
namespace {

/// The time between two readings of the certificates' files, longer than a check takes.
constexpr unsigned refresh_seconds = 3600;

std::shared_ptr<grpc::ChannelCredentials> credentials(const HealthCheck& question) {
  namespace tls = grpc::experimental;
  if (is_unix(question.address) || (question.ca.empty() && !question.tls.given()))
    return grpc::InsecureChannelCredentials();
  tls::TlsChannelCredentialsOptions options;
  const bool identified = !question.tls.client_ca.empty();
  if (!question.ca.empty() || identified)
    options.set_certificate_provider(std::make_shared<tls::FileWatcherCertificateProvider>(
        identified ? question.tls.key : "", identified ? question.tls.certificate : "", question.ca,
        refresh_seconds));
  if (identified) options.watch_identity_key_cert_pairs();
  if (!question.ca.empty()) {
    options.watch_root_certs();
  } else {
    options.set_verify_server_certs(false);
    options.set_certificate_verifier(std::make_shared<tls::NoOpCertificateVerifier>());
    options.set_check_call_host(false);
  }
  return tls::TlsCredentials(options);
}

}  // namespace

int health_check(const HealthCheck& question) {
  // grpc.health.v1.HealthCheckRequest and HealthCheckResponse, whose only fields have number 1.
  using Request = google::protobuf::StringValue;
  using Response = google::protobuf::Int32Value;
  constexpr int serving = 1;
  grpc::TemplatedGenericStub<Request, Response> stub(
      grpc::CreateChannel(question.address, credentials(question)));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(2));
  Request request;
  request.set_value(question.service);
  Response response;
  std::promise<grpc::Status> ended;
  stub.UnaryCall(&context, "/grpc.health.v1.Health/Check", {}, &request, &response,
                 [&](grpc::Status status) { ended.set_value(std::move(status)); });
  const grpc::Status status = ended.get_future().get();
  const bool serves = status.ok() && response.value() == serving;
  std::cerr << (!status.ok() ? question.address + ": " + status.error_message()
                : serves     ? "SERVING"
                             : "NOT_SERVING")
            << '\n';
  return serves ? 0 : 1;
}

}  // namespace stiefel::server
