#include "server/calls/durability.h"

#include <atomic>
#include <cstring>
#include <exception>
#include <mutex>
#include <sstream>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "server/convert/resolve.h"
#include "server/sessions/identity.h"

namespace stiefel::server {
namespace {

using Nanoseconds = std::chrono::nanoseconds;
using Time = std::chrono::system_clock::time_point;

/// Joins paths, which contain no line ends.
std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Adopts the state of a checkpoint if it is of this session and fits into the memory; leaves it
/// out otherwise, since it is only a cache.
void adopt(const StoredCheckpoint& checkpoint, Session& session) {
  if (checkpoint.numerics_id != numerics_id() || checkpoint.identity != hash(session.identity()) ||
      checkpoint.step < 0 || checkpoint.step > Session::max_step ||
      checkpoint.state.size() != session.saved_size() * sizeof(double))
    return;
  std::vector<double> saved(session.saved_size());
  std::memcpy(saved.data(), checkpoint.state.data(), checkpoint.state.size());
  session.adopt_if_it_fits(checkpoint.step, saved);
}

constexpr auto report_interval = std::chrono::seconds(1);

/// Hands rows to several threads, which make sessions of them; stops at the first exception.
class Rows {
 public:
  explicit Rows(Store& store) : reader_(store) {}

  template <class Use>
  void work(const Use& use) {
    try {
      while (const auto row = next()) use(*row);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
    }
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::optional<Store::Row> next() {
    const std::lock_guard lock(mutex_);
    return failure_ ? std::nullopt : reader_.next();
  }

  std::mutex mutex_;
  Store::Reader reader_;
  std::exception_ptr failure_;
};

}  // namespace

StoredSession to_row(const Session& session) {
  const Resolution& resolution = session.resolution();
  const auto created = session.create_time().time_since_epoch();
  return {session.owner(),
          session.id(),
          std::chrono::duration_cast<Nanoseconds>(created).count(),
          numerics_id(),
          hash(session.identity()),
          to_bytes(session.scene()),
          joined(resolution.difference.filled_in),
          joined(resolution.difference.cleared),
          resolution.choice};
}

Restored from_row(const Store::Row& row, std::shared_ptr<const Clock> clock, MemoryBudget& memory) {
  auto scene = scene_of(row.session.scene);
  if (!scene) return std::unexpected(std::move(scene.error()));
  auto session = std::make_shared<Session>(
      row.session.id, *std::move(scene), std::move(clock),
      Resolution{{split(row.session.filled_in), split(row.session.cleared)}, row.session.choice},
      memory);
  if (row.session.numerics_id == numerics_id() && row.session.identity != hash(session->identity()))
    return std::unexpected("this build reads its scene as a different scene");
  session->set_owner(row.session.principal);
  session->set_create_time(
      Time(std::chrono::duration_cast<Time::duration>(Nanoseconds(row.session.create_time))));
  if (row.checkpoint) adopt(*row.checkpoint, *session);
  return session;
}

Durability::Durability(const StoreOptions& options, Host& host, std::function<void(bool)> able)
    : file_(options.file),
      host_(host),
      able_(std::move(able)),
      store_(options),
      journal_(store_, hooks()) {
  host.registry.write_to(journal_);
}

Journal::Hooks Durability::hooks() {
  restore();
  return {to_row, [this](const Session& session) { host_.registry.drop(session); },
          [this](const WriteFault& fault) { report(fault); },
          [this](const std::optional<std::string>& fault) { watched(fault); }};
}

/// Restores a session. A principal's memory limit applies to new sessions only: a session that no
/// longer fits into it is charged to the whole server alone.
Restored Durability::restored(const Store::Row& row, Account& account) const {
  const auto with = [&](MemoryBudget& memory) {
    return from_row(row, host_.registry.clock(), memory);
  };
  try {
    return with(account.memory());
  } catch (const MemoryExhausted& exhausted) {
    if (!exhausted.part()) throw;
    return with(account.whole_memory());
  }
}

void Durability::restore_deleted_names() {
  using Time = WriteAheadLog::Time;
  const auto now = std::chrono::nanoseconds(Time::clock::now().time_since_epoch());
  for (DeletedName& deleted_name : store_.deleted_names(now.count())) {
    const std::chrono::nanoseconds until(deleted_name.until);
    host_.registry.mark_deleted(deleted_name.principal, std::move(deleted_name.id),
                                Time(std::chrono::duration_cast<Time::duration>(until)),
                                &host_.accounts.of(deleted_name.principal).memory());
  }
}

/// Restores the sessions even beyond the memory limit, because they were acknowledged: a server of
/// the same limit held them, without their caches. Gives up caches while there is too little
/// memory.
void Durability::restore_sessions(const std::function<void(const Store::Row&)>& use) {
  Rows rows(store_);
  host_.memory.allow_excess(true);
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < host_.threads; ++i) threads.emplace_back([&] { rows.work(use); });
  }
  host_.memory.allow_excess(false);
  rows.rethrow();
  const auto excess = [this] {
    const std::uint64_t used = host_.memory.used(), limit = host_.memory.limit();
    return used > limit ? used - limit : 0;
  };
  if (const std::uint64_t bytes = excess()) host_.registry.evict(bytes);
  if (const std::uint64_t bytes = excess())
    host_.log.line(Log::Level::warn, "stored sessions exceed the memory limit",
                   {{"bytes", static_cast<std::int64_t>(bytes)}});
}

void Durability::restore() {
  const auto start = std::chrono::steady_clock::now();
  const auto now = std::chrono::nanoseconds(WriteAheadLog::Time::clock::now().time_since_epoch());
  std::int64_t dropped = 0;
  try {
    store_.transact([&] {
      dropped = store_.drop_checkpoints_except(numerics_id());
      store_.trim_deleted_names(now.count());
    });
  } catch (const StoreError& error) {  // a full disk; checkpoints of other ids are not used anyway
    report(error.fault());
  }
  std::atomic<std::int64_t> unread = 0;
  const auto use = [&](const Store::Row& row) {
    Account& account = host_.accounts.of(row.session.principal);
    if (auto session = restored(row, account)) {
      (*session)->hold_permit(account.admit_restored_session());
      host_.registry.restore(*std::move(session));
    } else {
      ++unread;
      host_.log.line(Log::Level::error, "stored session cannot be restored",
                     {{"session", row.session.id}, {"error", session.error()}});
    }
  };
  try {
    restore_sessions(use);
    restore_deleted_names();
  } catch (const StoreError& error) {
    throw std::runtime_error("the store " + file_ + " is damaged: " + error.what() +
                             ": restore a backup");
  }
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  host_.log.line(Log::Level::info, "store opened",
                 {{"file", file_},
                  {"sessions", static_cast<std::int64_t>(host_.registry.size())},
                  {"unreadable", unread.load()},
                  {"checkpoints_dropped", dropped},
                  {"milliseconds", took.count()}});
}

/// Is called on the journal's thread, and during the restore.
void Durability::report(const WriteFault& fault) {
  ++unreported_;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_report_) return;
  next_report_ = now + report_interval;
  host_.log.line(Log::Level::error, "store not written",
                 {{"error", fault.what}, {"count", std::exchange(unreported_, 0)}});
}

/// Is called on the journal's thread.
void Durability::watched(const std::optional<std::string>& fault) const {
  able_(!fault);
  if (fault)
    host_.log.line(Log::Level::error, "store lost", {{"error", *fault}});
  else
    host_.log.line(Log::Level::warn, "store there again", {{"file", file_}});
}

}  // namespace stiefel::server
