#include "server/check.h"

#include <chrono>
#include <exception>
#include <iostream>
#include <thread>

#include "server/access/callers.h"
#include "server/access/certificates.h"
#include "server/access/watched_files.h"
#include "server/limits/process.h"
#include "server/metrics/exporter.h"
#include "server/store/store_file.h"
#include "server/transport/listener.h"

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

}  // namespace

int threads_of(const Options& options) {
  return other_threads + (options.threads > 0
                              ? options.threads
                              : static_cast<int>(std::thread::hardware_concurrency()));
}

int check(const Options& options) {
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

}  // namespace stiefel::server
