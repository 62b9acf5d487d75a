#include "server/calls/durability.h"

#include <atomic>
#include <future>
#include <mutex>
#include <utility>
#include <vector>

#include "server/convert/convert.h"
#include "server/convert/resolve.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/identity.h"

namespace stiefel::server {
namespace {

constexpr auto checkpoint_interval = std::chrono::seconds(2),
               report_interval = std::chrono::seconds(1);
constexpr std::size_t most_checkpoint_bytes = std::size_t{16} << 20;

std::int64_t nanoseconds(Registry::Time time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}
Registry::Time time_at(std::int64_t nanoseconds) {
  return Registry::Time(
      std::chrono::duration_cast<Registry::Time::duration>(std::chrono::nanoseconds(nanoseconds)));
}

}  // namespace

StoredSession to_row(const RegisteredSession& session) {
  v1::Choice choice;
  if (session.choice()) to_proto(*session.choice(), &choice);
  return {session.owner(),
          session.id(),
          nanoseconds(session.create_time()),
          numerics_id(),
          session.identity(),
          to_bytes(session.scene()),
          choice.SerializeAsString()};
}

Restored from_row(const Store::Row& row, std::shared_ptr<const Clock> clock, MemoryBudget& memory) {
  const StoredSession& stored = row.session;
  auto scene = scene_of(stored.scene);
  if (!scene) return std::unexpected(std::move(scene.error()));
  auto session = std::make_shared<RegisteredSession>(stored.principal, stored.id, *std::move(scene),
                                                     choice_of(stored.choice), std::move(clock),
                                                     memory, time_at(stored.create_time));
  if (stored.numerics_id == numerics_id() && stored.identity != session->identity())
    return std::unexpected("this build reads its scene as a different scene");
  if (auto checkpoint = decode_checkpoint(*session, row.checkpoint))
    session->restore_checkpoint(checkpoint->step, std::move(checkpoint->saved), false);
  return session;
}

Durability::Durability(const std::string& file, Host& host, std::function<void(bool)> able)
    : file_(file),
      host_(host),
      able_(std::move(able)),
      store_(file),
      writer_(store_),
      periodic_("checkpoints", checkpoint_interval, [this](const auto&) {
        watch();
        write_checkpoints();
      }) {
  restore();
  host.registry.record_with([this](Registry::Change change) { return record(std::move(change)); });
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

/// Restores the sessions, on several threads, even beyond the memory limit, because they were
/// acknowledged: a server of the same limit held them, without their caches. Gives up caches while
/// there is too little memory.
void Durability::restore_sessions(const std::function<void(const Store::Row&)>& use) {
  Store::Reader reader(store_);
  std::mutex reading;
  const auto next = [&] {
    const std::lock_guard lock(reading);
    return reader.next();
  };
  host_.memory.allow_excess(true);
  std::vector<std::future<void>> threads;
  for (int i = 0; i < host_.threads; ++i)
    threads.push_back(std::async(std::launch::async, [&] {
      while (const auto row = next()) use(*row);
    }));
  for (auto& thread : threads) thread.get();
  host_.memory.allow_excess(false);
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
  std::atomic<std::int64_t> unread = 0;
  const auto use = [&](const Store::Row& row) {
    Account& account = host_.accounts.of(row.session.principal);
    if (auto session = restored(row, account)) {
      (*session)->hold_slot(*account.admit_session(true));
      host_.registry.restore(*std::move(session));
    } else {
      ++unread;
      host_.log.line(Log::Level::error, "stored session cannot be restored",
                     {{"session", row.session.id}, {"error", session.error()}});
    }
  };
  try {
    restore_sessions(use);
    for (Tombstone& one : store_.tombstones(nanoseconds(Registry::Time::clock::now())))
      host_.registry.restore_deletion(one.principal, std::move(one.id), time_at(one.until),
                                      &host_.accounts.of(one.principal).memory());
  } catch (const StoreError& error) {
    throw std::runtime_error("the store " + file_ + " is damaged: " + error.what() +
                             ": restore a backup");
  }
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  host_.log.line(Log::Level::info, "store opened",
                 {{"file", file_},
                  {"sessions", static_cast<std::int64_t>(host_.registry.size())},
                  {"unreadable", unread.load()},
                  {"milliseconds", took.count()}});
}

PendingWrite Durability::record(Registry::Change change) {
  const auto session = change.session;
  const auto on_fault = [this, session](const WriteFault& fault) {
    report(fault);
    if (session) host_.registry.drop(*session);
  };
  return writer_.submit(
      [change = std::move(change)](Store& store) {
        if (change.session) return store.put(to_row(*change.session));
        store.erase(change.principal, change.id);
        if (change.until)
          store.put(Tombstone{change.principal, change.id, nanoseconds(*change.until)});
      },
      on_fault);
}

void Durability::write_checkpoints() noexcept try {
  struct New {
    std::shared_ptr<RegisteredSession> session;
    Checkpoints::Nearest state;
  };
  std::vector<New> found;
  std::size_t bytes = 0;
  for (auto& session : host_.registry.with_new_states()) {
    if (bytes + checkpoint_bytes(*session) > most_checkpoint_bytes) continue;
    if (auto state = session->take_new_state()) {
      bytes += checkpoint_bytes(*session);
      found.push_back({std::move(session), *std::move(state)});
    }
  }
  if (found.empty()) return;
  writer_.submit(
      [found = std::move(found)](Store& store) {
        for (const auto& [session, state] : found)
          if (!session->closed())  // else the row is gone, or belongs to another session
            store.put_checkpoint(session->owner(), session->id(),
                                 encode_checkpoint(*session, state.step, *state.saved));
      },
      [this](const WriteFault& fault) { report(fault); });
} catch (const std::exception&) {  // no memory; a checkpoint is not needed
}

/// Is called on the writer's thread.
void Durability::report(const WriteFault& fault) try {
  ++unreported_;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_report_) return;
  next_report_ = now + report_interval;
  host_.log.line(Log::Level::error, "store not written",
                 {{"error", fault.what}, {"count", std::exchange(unreported_, 0)}});
} catch (const std::exception&) {  // no memory for a line of the log
}

void Durability::watch() {
  auto fault = store_.fault();
  if (fault == watched_) return;
  able_(!fault);
  if (fault)
    host_.log.line(Log::Level::error, "store lost", {{"error", *fault}});
  else
    host_.log.line(Log::Level::warn, "store there again", {{"file", file_}});
  watched_ = std::move(fault);
}

}  // namespace stiefel::server
