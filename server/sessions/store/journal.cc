#include "server/sessions/store/journal.h"

#include <pthread.h>

#include <algorithm>
#include <new>
#include <utility>

#include "server/sessions/identity.h"
#include "server/sessions/server_session.h"

namespace stiefel::server {
namespace {

/// The name of the thread in ps and top.
constexpr const char* thread_name = "store";
/// How long waiting changes may delay the checkpoints.
constexpr auto longest_delay = std::chrono::seconds(5);

std::int64_t nanoseconds_of(WriteAheadLog::Time time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}
std::int64_t nanoseconds_now() { return nanoseconds_of(WriteAheadLog::Time::clock::now()); }

WriteFault fault_of_current_exception() {
  try {
    try {
      throw;
    } catch (const StoreError& error) {
      return error.fault();
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      return {WriteFault::Kind::damaged, error.what()};
    }
  } catch (const std::bad_alloc&) {
    return {WriteFault::Kind::out_of_memory, {}};
  }
}

StoredCheckpoint to_row(const Session& session, const Checkpoints::Nearest& last) {
  const auto& numbers = *last.saved;
  return {
      session.owner(),
      session.id(),
      numerics_id(),
      hash(session.identity()),
      last.step,
      std::string(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double))};
}

}  // namespace

Journal::Journal(Store& store, Hooks hooks, std::chrono::milliseconds between_checkpoints)
    : store_(store),
      hooks_(std::move(hooks)),
      between_checkpoints_(between_checkpoints),
      thread_([this](const std::stop_token& stop) { work(stop); }) {}

Journal::~Journal() {
  thread_.request_stop();
  thread_.join();
}

std::shared_ptr<PendingWrite> Journal::submit(Change change) {
  auto pending_write = change.pending_write;
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back(std::move(change));
  }
  wake_.notify_one();
  return pending_write;
}

void Journal::cached(std::weak_ptr<Session> session) noexcept {
  try {
    const std::lock_guard lock(mutex_);
    with_states_.push_back(std::move(session));
  } catch (const std::bad_alloc&) {  // checkpoints are best effort
  }
}

void Journal::work(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), thread_name);
  const auto now = &std::chrono::steady_clock::now;
  auto next_pass = now() + between_checkpoints_;
  std::vector<Change> changes;
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait_until(lock, stop, next_pass, [this] { return !queue_.empty(); });
    const bool stopping = stop.stop_requested();
    if (!queue_.empty()) {
      changes.swap(queue_);
      lock.unlock();
      write(changes);
      changes.clear();
      lock.lock();
    }
    const bool due = now() >= next_pass && (queue_.empty() || now() >= next_pass + longest_delay);
    if (due || (stopping && queue_.empty())) {
      auto sessions = std::exchange(with_states_, {});
      lock.unlock();
      watch();
      if (!sessions.empty()) write_checkpoints(std::move(sessions));
      lock.lock();
      next_pass = now() + between_checkpoints_;
    }
    if (stopping && queue_.empty()) return;
  }
}

void Journal::write(std::span<const Change> changes) {
  while (!changes.empty()) {
    std::size_t count = 0, bytes = 0;
    while (count < std::min(changes.size(), max_changes) && bytes < max_bytes)
      if (const auto& session = changes[count++].session) bytes += session->scene_bytes();
    changes = changes.subspan(write_together(changes.first(count)));
  }
  if (store_.deleted_names_pile_up()) trim_deleted_names();
}

void Journal::trim_deleted_names() noexcept {
  try {
    store_.transact([this] { store_.trim_deleted_names(nanoseconds_now()); }, Store::Patience(0));
  } catch (...) {  // untrimmed deleted names only take space
  }
}

/// Returns how many of the changes have an outcome. While another program holds the lock, those
/// have one whose time is over.
std::size_t Journal::write_together(std::span<const Change> changes) {
  using Kind = WriteFault::Kind;
  const auto fault = transact(changes);
  if (fault && fault->kind == Kind::locked) {
    const auto now = std::chrono::steady_clock::now();
    const auto waits = [&](const Change& change) { return change.deadline > now; };
    changes = changes.first(static_cast<std::size_t>(
        std::find_if(changes.begin() + 1, changes.end(), waits) - changes.begin()));
  } else if (fault && fault->kind != Kind::unavailable) {
    if (fault->kind == Kind::full) store_.empty_log();
    for (const Change& change : changes) settle(change, transact({&change, 1}));
    return changes.size();
  }
  for (const Change& change : changes) settle(change, fault);
  return changes.size();
}

std::optional<WriteFault> Journal::transact(std::span<const Change> changes) {
  const auto left = std::chrono::duration_cast<Store::Patience>(changes.front().deadline -
                                                                std::chrono::steady_clock::now());
  try {
    store_.transact(
        [&] {
          for (const Change& change : changes) apply(change);
        },
        std::max(left, Store::Patience(0)));
    transactions_.fetch_add(1, std::memory_order_relaxed);
    return std::nullopt;
  } catch (...) {
    return fault_of_current_exception();
  }
}

void Journal::apply(const Change& change) {
  if (change.session) return store_.put(hooks_.to_row(*change.session));
  store_.erase(change.principal, change.id);
  if (change.until)
    store_.put(DeletedName{change.principal, change.id, nanoseconds_of(*change.until)});
}

void Journal::settle(const Change& change, const std::optional<WriteFault>& fault) {
  if (fault) report(*fault);
  if (fault && change.session) hooks_.drop(*change.session);
  change.pending_write->settle(fault);
}

void Journal::watch() noexcept {
  try {
    auto now = store_.fault();
    if (now == watched_) return;
    watched_ = std::move(now);
    if (hooks_.watched) hooks_.watched(watched_);
  } catch (const std::exception&) {  // no memory for the message
  }
}

void Journal::report(const WriteFault& fault) const noexcept {
  try {
    hooks_.report(fault);
  } catch (const std::exception&) {  // no memory for a line of the log
  }
}

void Journal::write_checkpoints(std::vector<std::weak_ptr<Session>> sessions) {
  std::size_t bytes = 0;
  try {
    const auto put_last_states = [&] {
      for (const auto& one : sessions) {
        const auto session = one.lock();
        if (!session) continue;
        const auto last = session->take_last_state();
        const std::size_t size = session->saved_size() * sizeof(double);
        // The row of a closed session is gone or belongs to another session.
        if (session->closed() || last.step == 0 || bytes + size > max_checkpoint_bytes) continue;
        bytes += size;
        store_.put(to_row(*session, last));
      }
    };
    store_.transact(put_last_states, Store::Patience(0));
  } catch (...) {
    report(fault_of_current_exception());
  }
}

}  // namespace stiefel::server
