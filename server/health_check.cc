#include "server/check.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <iostream>

#include "grpc/health/v1/health.grpc.pb.h"
#include "server/address.h"
#include "server/flags.h"
#include "server/transport/listener.h"

namespace stiefel::server {
namespace {

/// The time between two readings of the certificates' files, longer than a check takes.
constexpr unsigned refresh_seconds = 3600;

/// Whether the address is one of this machine's own, or stands for all of them.
bool is_this_machine(const std::string& address) {
  return address.starts_with("0.0.0.0:") || address.starts_with("[::]:") ||
         std::ranges::all_of(tcp_addresses(address), is_local);
}

/// Returns the credentials of the check. Without authorities, any certificate is accepted on this
/// machine's own addresses: nobody is in between, and neither question nor answer is secret.
std::shared_ptr<grpc::ChannelCredentials> credentials(const HealthCheck& question,
                                                      const std::string& address) {
  namespace tls = grpc::experimental;
  if (is_unix(address) || (question.ca.empty() && !question.tls.given()))
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
  } else if (is_this_machine(address)) {
    options.set_verify_server_certs(false);
    options.set_certificate_verifier(std::make_shared<tls::NoOpCertificateVerifier>());
    options.set_check_call_host(false);
  }
  return tls::TlsCredentials(options);
}

}  // namespace

int health_check(const HealthCheck& question) {
  const std::string address = question.address.substr(0, question.address.find(','));
  if (const std::string fault = address_error(address); !fault.empty()) {
    std::cerr << "--address: " << fault << '\n';
    return 1;
  }
  const auto stub = grpc::health::v1::Health::NewStub(
      grpc::CreateChannel(address, credentials(question, address)));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(2));
  grpc::health::v1::HealthCheckRequest request;
  request.set_service(question.service);
  grpc::health::v1::HealthCheckResponse response;
  const auto status = stub->Check(&context, request, &response);
  if (!status.ok()) {
    std::cerr << address << ": " << status.error_message() << '\n';
    return 1;
  }
  std::cerr << grpc::health::v1::HealthCheckResponse::ServingStatus_Name(response.status()) << '\n';
  return response.status() == grpc::health::v1::HealthCheckResponse::SERVING ? 0 : 1;
}

}  // namespace stiefel::server
