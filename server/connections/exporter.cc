#include "server/connections/exporter.h"

#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <chrono>
#include <exception>
#include <iterator>
#include <list>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "server/connections/certificates.h"
#include "server/connections/listener.h"

namespace stiefel::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using asio::use_awaitable;
using asio::ip::tcp;
using namespace std::chrono_literals;

constexpr std::size_t connections_at_once = 32;
constexpr std::size_t largest_request = 8192;  // bytes
constexpr auto request_patience = 2s, answer_patience = 10s;
/// The wait after a failed accept, when the process has no descriptor left.
constexpr auto pause = 100ms;

tcp::acceptor acceptor_of(asio::io_context& context, Listener&& listener) {
  const bool ipv6 = listener.address.storage.ss_family == AF_INET6;
  return tcp::acceptor(context, ipv6 ? tcp::v6() : tcp::v4(), listener.socket.release());
}

/// Returns all families as text, without those that cannot be made for want of memory.
std::string page_of(const Exporter::Metrics& metrics) {
  std::vector<prometheus::MetricFamily> families;
  for (const auto& one : metrics) {
    try {
      std::ranges::move(one->Collect(), std::back_inserter(families));
    } catch (const std::exception&) {
    }
  }
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace

std::optional<std::string> metrics_fault(const std::string& address, bool guarded) {
  if (is_unix(address)) return "must be host:port, because Prometheus reads no Unix sockets";
  return guarded ? std::nullopt : exposure_fault(address);
}

struct Exporter::Parts {
  Parts(Metrics all, TlsContext given) : metrics(std::move(all)) {
    if (given) tls.emplace(given.release());
  }
  ~Parts() { context.stop(); }

  http::response<http::string_body> answer(const http::request<http::empty_body>& request) const {
    http::response<http::string_body> response(http::status::ok, 11);
    const std::string_view target(request.target().data(), request.target().size());
    if (request.version() != 10 && request.version() != 11) {
      response.result(http::status::http_version_not_supported);
    } else if (target.substr(0, target.find('?')) != "/metrics") {
      response.result(http::status::not_found);
    } else if (request.method() != http::verb::get) {
      response.result(http::status::method_not_allowed);
      response.set(http::field::allow, "GET");
    } else {
      response.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
      response.body() = page_of(metrics);
    }
    response.keep_alive(false);
    response.prepare_payload();
    return response;
  }

  struct Connection {
    beast::tcp_stream stream;
    bool silent = true;  // its request is not complete
  };

  template <class Stream>
  asio::awaitable<void> converse(Stream& stream, Connection& connection) const {
    beast::flat_buffer buffer(largest_request);
    http::request_parser<http::empty_body> request;
    request.header_limit(largest_request);
    co_await http::async_read_header(stream, buffer, request, use_awaitable);
    connection.silent = false;
    connection.stream.expires_after(answer_patience);
    const auto response = answer(request.get());
    co_await http::async_write(stream, response, use_awaitable);
  }

  asio::awaitable<void> serve(Connection& connection) {
    connection.stream.expires_after(request_patience);
    if (!tls) {
      co_await converse(connection.stream, connection);
      connection.stream.socket().shutdown(tcp::socket::shutdown_send);
    } else {
      asio::ssl::stream<beast::tcp_stream&> encrypted(connection.stream, *tls);
      co_await encrypted.async_handshake(asio::ssl::stream_base::server, use_awaitable);
      co_await converse(encrypted, connection);
      co_await encrypted.async_shutdown(use_awaitable);
    }
  }

  asio::awaitable<void> hold(tcp::socket socket) {
    if (open.size() >= connections_at_once) give_way();
    const auto place = open.emplace(open.end(), beast::tcp_stream(std::move(socket)));
    try {
      co_await serve(*place);
    } catch (const std::exception&) {  // the reader went away, was too slow or gave way
    }
    open.erase(place);
  }

  /// Ends the oldest connection without a request or, if there is none, the oldest, whose coroutine
  /// then leaves the list.
  void give_way() {
    const auto is_open = [](const Connection& one) { return one.stream.socket().is_open(); };
    auto oldest = std::ranges::find_if(
        open, [&](const Connection& one) { return one.silent && is_open(one); });
    if (oldest == open.end()) oldest = std::ranges::find_if(open, is_open);
    if (oldest != open.end()) oldest->stream.close();
  }

  asio::awaitable<void> accept(tcp::acceptor& acceptor) {
    for (;;) {
      bool accepted = false;
      try {
        tcp::socket socket = co_await acceptor.async_accept(use_awaitable);
        accepted = true;
        asio::co_spawn(context, hold(std::move(socket)), asio::detached);
      } catch (const std::exception&) {  // no descriptor or no memory
      }
      if (!accepted) co_await asio::steady_timer(context, pause).async_wait(use_awaitable);
    }
  }

  const Metrics metrics;
  std::optional<asio::ssl::context> tls;
  asio::io_context context{1};
  std::list<tcp::acceptor> acceptors;
  std::list<Connection> open;  // the oldest first
  std::jthread thread;         // last, so that it ends before what it uses
};

Exporter::Exporter(const std::string& address, Metrics metrics,
                   const ServedCertificates* certificates)
    : parts_(std::make_unique<Parts>(std::move(metrics),
                                     certificates ? tls_context(*certificates) : TlsContext())) {
  std::vector<Listener> listeners = listen_on(address);
  url_ = (certificates ? "https://" : "http://") + address.substr(0, address.rfind(':') + 1) +
         std::to_string(listeners.front().port) + "/metrics";
  for (Listener& listener : listeners) {
    tcp::acceptor& acceptor =
        parts_->acceptors.emplace_back(acceptor_of(parts_->context, std::move(listener)));
    asio::co_spawn(parts_->context, parts_->accept(acceptor), asio::detached);
  }
  parts_->thread = std::jthread([&context = parts_->context] {
    pthread_setname_np(pthread_self(), "metrics");
    context.run();
  });
}

Exporter::~Exporter() = default;

}  // namespace stiefel::server
