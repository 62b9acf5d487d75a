#include "server/calls/health_service.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "server/convert/errors.h"

namespace stiefel::server {
namespace {

constexpr std::uint64_t watch_bytes = 20 << 10;

grpc::Status too_many(std::size_t most) {
  const auto limit = static_cast<double>(most);
  return errors::over_quota({"health_watches", limit, limit + 1, std::chrono::seconds(1)});
}

}  // namespace

std::size_t HealthService::most_watches(std::uint64_t memory) {
  return std::max<std::uint64_t>(memory / 64 / watch_bytes, 64);
}

HealthService::HealthService(std::string service, std::size_t most_watches)
    : service_(std::move(service)), most_(most_watches) {}

/// Tells one caller the status, and again at every change. Its members are guarded by the service's
/// lock. Deletes itself.
class HealthService::Watcher final : public grpc::ServerWriteReactor<Response> {
 public:
  /// Requires the lock, as does `tell`.
  Watcher(HealthService& health, std::string connection, bool known)
      : health_(health), connection_(std::move(connection)), known_(known) {
    tell();
  }
  void tell() {
    const auto now = health_.status(known_);
    if (writing_ || ended_ || (told_ && now == response_.status())) return;
    told_ = writing_ = true;
    response_.set_status(now);
    StartWrite(&response_);
  }
  const std::string& connection() const { return connection_; }

  void OnWriteDone(bool ok) override {
    const std::lock_guard lock(health_.mutex_);
    writing_ = false;
    ok ? tell() : end();
  }
  void OnCancel() override {
    const std::lock_guard lock(health_.mutex_);
    end();
  }
  void OnDone() override {
    {
      const std::lock_guard lock(health_.mutex_);
      health_.leave(this);
    }
    delete this;
  }

 private:
  void end() {
    if (!std::exchange(ended_, true)) Finish(errors::cancelled());
  }

  HealthService& health_;
  const std::string connection_;
  const bool known_;
  Response response_;
  bool told_ = false, writing_ = false, ended_ = false;
};

void HealthService::leave(Watcher* watcher) {
  watchers_.erase(watcher);
  const auto here = of_connection_.find(watcher->connection());
  if (--here->second == 0) of_connection_.erase(here);
}

void HealthService::tell_all() {
  for (Watcher* watcher : watchers_) watcher->tell();
}

class HealthService::RefusedWatch final : public grpc::ServerWriteReactor<Response> {
 public:
  explicit RefusedWatch(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

grpc::ServerUnaryReactor* HealthService::Check(Context* context, const Request* request,
                                               Response* response) {
  auto* reactor = context->DefaultReactor();
  if (!knows(request->service())) {
    reactor->Finish({grpc::NOT_FOUND, "there is no such service"});
    return reactor;
  }
  {
    const std::lock_guard lock(mutex_);
    response->set_status(status(true));
  }
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

grpc::ServerWriteReactor<HealthService::Response>* HealthService::Watch(Context* context,
                                                                        const Request* request) {
  const std::string connection = context->peer();
  const std::lock_guard lock(mutex_);
  if (watchers_.size() >= most_) return new RefusedWatch(too_many(most_));
  std::size_t& here = of_connection_[connection];
  if (here >= most_of_connection) return new RefusedWatch(too_many(most_of_connection));
  ++here;
  return *watchers_.insert(new Watcher(*this, connection, knows(request->service()))).first;
}

}  // namespace stiefel::server
