#include "server/program/check.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <iostream>
#include <thread>

#include "grpc/health/v1/health.grpc.pb.h"
#include "server/connections/callers.h"
#include "server/connections/certificates.h"
#include "server/connections/exporter.h"
#include "server/connections/listener.h"
#include "server/connections/watched_files.h"
#include "server/program/command_line.h"
#include "server/program/flags.h"
#include "server/scheduling/process.h"
#include "server/sessions/store/store_file.h"

namespace stiefel::server {
namespace {

using Faults = std::vector<std::string>;

void check_addresses(const Options& options, Faults& faults) {
  const bool guarded = options.access.tls.given() || options.access.insecure;
  for (const std::string& address : options.listen) {
    const std::string place = "--listen: " + address + ": ";
    if (const auto fault = listen_fault(address))
      faults.push_back(place + *fault);
    else if (const auto exposed = guarded ? std::nullopt : exposure_fault(address))
      faults.push_back(place + *exposed);
  }
  if (options.metrics.empty()) return;
  const std::string place = "--metrics: " + options.metrics + ": ";
  if (const auto fault = metrics_fault(options.metrics, guarded))
    faults.push_back(place + *fault);
  else if (const auto none = listen_fault(options.metrics))
    faults.push_back(place + *none);
}

void check_files(const AccessOptions& access, Faults& faults) {
  if (access.tls.given()) {
    const auto found = certificates(access.tls, read_texts(paths_of(access.tls)));
    if (!found)
      faults.push_back(found.error());
    else if (found->expire_time < std::chrono::system_clock::now())
      faults.push_back("--tls-cert: " + access.tls.certificate + ": it has expired");
  }
  if (!access.tokens.empty())
    for (const std::string& fault : faults_of_tokens(access.tokens))
      faults.push_back("--tokens: " + access.tokens + ": " + fault);
  try {
    checkpoint_keys(access.checkpoint_key);
  } catch (const std::exception& fault) {
    faults.emplace_back(fault.what());
  }
}

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

int threads_of(const Options& options) {
  return other_threads + (options.threads > 0
                              ? options.threads
                              : static_cast<int>(std::thread::hardware_concurrency()));
}

int check(const Options& options) {
  for (const std::string& text : unknown_variables()) std::cerr << "warning: " << text << '\n';
  Faults faults;
  check_addresses(options, faults);
  check_files(options.access, faults);
  if (const auto fault = store_fault(options.store)) faults.push_back("--store: " + *fault);
  enlarge_thread_stacks();
  if (const auto fault = thread_fault(threads_of(options)))
    faults.push_back("--threads: " + *fault);
  raise_descriptor_limit();
  const std::size_t most = possible_connections(options.connections.most);
  if (most < options.connections.most)
    faults.push_back("--max-connections: " + std::to_string(options.connections.most) +
                     ": must be at most " + std::to_string(most) +
                     ", by the limit of file descriptors");
  for (const std::string& fault : faults) std::cerr << fault << '\n';
  if (!faults.empty()) return 1;
  const Quota limits = limits_of_principals(options);
  const auto text = [](std::uint64_t limit) {
    return limit > 0 ? std::to_string(limit) : "no limit";
  };
  std::cout << "the flags are sound; connections at once: " << most
            << "; of one principal, sessions: " << text(*limits.sessions)
            << ", bytes of memory: " << text(*limits.memory) << '\n';
  return 0;
}

int health_check(const HealthCheck& question) {
  const std::string& address = question.address;
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
