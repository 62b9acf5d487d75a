#include "server/program/check.h"

#include <google/protobuf/wrappers.pb.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <future>
#include <iostream>
#include <thread>

#include "server/connections/exporter.h"
#include "server/connections/listener.h"
#include "server/program/command_line.h"
#include "server/program/flags.h"
#include "server/scheduling/process.h"
#include "server/sessions/store/store_file.h"

namespace stiefel::server {
namespace {

using Faults = std::vector<std::string>;

/// Returns why the address cannot be listened on. A server that listens there already is no fault.
std::optional<std::string> listen_fault(const std::string& address) try {
  const bool there = is_unix(address) && std::filesystem::is_socket(unix_path(address));
  if (!there)
    listen_on(is_unix(address) ? address : address.substr(0, address.rfind(':') + 1) + "0");
  return std::nullopt;
} catch (const std::exception& fault) {
  return fault.what();
}

void check_addresses(const Options& options, Faults& faults) {
  const bool guarded = options.access.tls.given() || options.access.insecure;
  const auto check = [&](const std::string& flag, const std::string& address,
                         std::optional<std::string> fault) {
    if (!fault) fault = listen_fault(address);
    if (fault) faults.push_back(flag + ": " + address + ": " + *fault);
  };
  for (const std::string& address : options.listen)
    check("--listen", address, guarded ? std::nullopt : exposure_fault(address));
  if (!options.metrics.empty())
    check("--metrics", options.metrics, metrics_fault(options.metrics, options.access.insecure));
}

/// Makes a server that neither listens nor opens the store, which the server that runs holds.
void construct(Options options, Faults& faults) try {
  options.listen.clear();
  options.metrics.clear();
  options.store.clear();
  options.log_level = "warn";
  const Server server(options);
} catch (const std::exception& fault) {
  faults.emplace_back(fault.what());
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
  if (const auto fault = store_fault(options.store)) faults.push_back("--store: " + *fault);
  enlarge_thread_stacks();
  if (const auto fault = thread_fault(threads_of(options)))
    faults.push_back("--threads: " + *fault);
  else
    construct(options, faults);
  for (const std::string& fault : faults) std::cerr << fault << '\n';
  if (!faults.empty()) return 1;
  const Quota limits = limits_of_principals(options);
  const auto text = [](std::uint64_t limit) {
    return limit > 0 ? std::to_string(limit) : "no limit";
  };
  std::cout << "the flags are sound; of one principal, sessions: " << text(*limits.sessions)
            << ", bytes of memory: " << text(*limits.memory) << '\n';
  return 0;
}

int health_check(const HealthCheck& question) {
  const std::string& address = question.address;
  if (const std::string fault = address_error(address); !fault.empty()) {
    std::cerr << "--address: " << fault << '\n';
    return 1;
  }
  // grpc.health.v1.HealthCheckRequest and HealthCheckResponse, whose only fields have number 1.
  using Request = google::protobuf::StringValue;
  using Response = google::protobuf::Int32Value;
  constexpr int serving = 1;
  grpc::TemplatedGenericStub<Request, Response> stub(
      grpc::CreateChannel(address, credentials(question, address)));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(2));
  Request request;
  request.set_value(question.service);
  Response response;
  std::promise<grpc::Status> ended;
  stub.UnaryCall(&context, "/grpc.health.v1.Health/Check", {}, &request, &response,
                 [&](grpc::Status status) { ended.set_value(std::move(status)); });
  const grpc::Status status = ended.get_future().get();
  if (!status.ok()) {
    std::cerr << address << ": " << status.error_message() << '\n';
    return 1;
  }
  const bool serves = response.value() == serving;
  std::cerr << (serves ? "SERVING" : "NOT_SERVING") << '\n';
  return serves ? 0 : 1;
}

}  // namespace stiefel::server
