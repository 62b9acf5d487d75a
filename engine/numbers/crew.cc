#include "stiefel/crew.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "engine/numbers/parallel.h"

namespace stiefel {
namespace {

thread_local Crew* crew_of_this_thread = nullptr;
thread_local bool within_item = false;

void pause() {
#ifdef STIEFEL_X86_64
  __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

/// The threads of the library. They start when they are first wanted and live as long as the
/// process.
class OwnCrew final : public Crew {
 public:
  void limit(std::size_t threads) { limit_.store(threads, std::memory_order_relaxed); }

  std::size_t threads_at_hand() override { return limit_.load(std::memory_order_relaxed); }

  void run(std::size_t count, double, Item item, void* context) override {
    thread_local const auto team = std::make_shared<Team>();
    if (count > 1 && may_help()) call(team, count - 1);
    team->run(count, 1, item, context);
  }

 private:
  bool may_help() { return busy_.load(std::memory_order_relaxed) + 1 < threads_at_hand(); }

  /// Asks for helpers of a team up to `wanted`, with those that it has or has asked for: each holds
  /// the team.
  void call(const std::shared_ptr<Team>& team, std::size_t wanted) {
    const std::lock_guard lock(mutex_);
    const std::size_t most = threads_at_hand() - 1;
    for (auto k = static_cast<std::size_t>(team.use_count()) - 1; k < std::min(wanted, most); ++k)
      wanted_.push_back(team);
    try {
      for (; threads_ < std::min(most, busy_ + wanted_.size()); ++threads_)
        std::thread([this] { work(); }).detach();
    } catch (const std::exception&) {  // there are as many threads as there can be
    }
    if (!wanted_.empty()) wake_.notify_all();
  }

  [[noreturn]] void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [&] { return !wanted_.empty() && may_help(); });
      auto team = std::move(wanted_.front());
      wanted_.pop_front();
      ++busy_;
      lock.unlock();
      team->help([this] { return busy_.load(std::memory_order_relaxed) >= threads_at_hand(); },
                 [] { return 0.0; });
      lock.lock();
      --busy_;
      team.reset();
    }
  }

  std::atomic<std::size_t> limit_ = std::max(1U, std::thread::hardware_concurrency());
  std::atomic<std::size_t> busy_ = 0;  // threads that help
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::shared_ptr<Team>> wanted_;  // one for each helper that a team wants
  std::size_t threads_ = 0;
};

OwnCrew& own_crew() {
  static OwnCrew& crew = *new OwnCrew;  // never destroyed: its threads end with the process
  return crew;
}

}  // namespace

CrewOfThisThread::CrewOfThisThread(Crew& crew) { crew_of_this_thread = &crew; }
CrewOfThisThread::~CrewOfThisThread() { crew_of_this_thread = nullptr; }
Crew* CrewOfThisThread::find() { return within_item ? nullptr : crew_of_this_thread; }

void limit_threads(int threads) {
  own_crew().limit(static_cast<std::size_t>(std::max(threads, 1)));
}

Crew* crew_to_divide() {
  if (within_item) return nullptr;
  return crew_of_this_thread ? crew_of_this_thread : &own_crew();
}

struct Team::Run {
  const std::size_t count, portion;
  const Crew::Item item;
  void* const context;
  std::atomic<std::size_t> next = 0;
  std::atomic_flag failed{};
  std::exception_ptr failure = nullptr;  // of the thread that set `failed`

  /// Does items until none is left or `leave` returns true.
  template <class Leave>
  void work(const Leave& leave) noexcept {
    const bool outer = std::exchange(within_item, true);
    try {
      while (!leave()) {
        const std::size_t first = next.fetch_add(portion, std::memory_order_relaxed);
        if (first >= count) break;
        for (std::size_t i = first; i < std::min(first + portion, count); ++i) item(context, i);
      }
    } catch (...) {
      if (!failed.test_and_set()) failure = std::current_exception();
      next.store(count, std::memory_order_relaxed);
    }
    within_item = outer;
  }
};

void Team::run(std::size_t count, std::size_t portion, Crew::Item item, void* context) {
  constexpr int most_spins = 2000;
  Run run{count, portion, item, context};
  run_.store(&run);
  runs_.fetch_add(1);
  run.work([] { return false; });
  run_.store(nullptr);
  // A helper that read run_ before has been counted in inside_ before: both are sequentially
  // consistent.
  for (int spins = 0; const std::uint32_t inside = inside_.load(); ++spins)
    spins < most_spins ? pause() : inside_.wait(inside);
  if (run.failure) std::rethrow_exception(run.failure);
}

bool Team::help(const std::function<bool()>& leave, const std::function<double()>& meter) {
  constexpr int spins_between_clocks = 32;
  using Clock = std::chrono::steady_clock;
  Clock::time_point end = Clock::now() + patience;
  std::uint64_t seen = 0;
  for (int spins = 1; !leave(); ++spins) {
    if (const std::uint64_t runs = runs_.load(); runs != seen) {
      seen = runs;
      inside_.fetch_add(1);
      if (Run* run = run_.load()) {
        const double before = meter();
        run->work(leave);
        helpers_work_.fetch_add(meter() - before, std::memory_order_relaxed);
      }
      if (inside_.fetch_sub(1) == 1) inside_.notify_one();
      end = Clock::now() + patience;
    } else if (spins % spins_between_clocks == 0 && Clock::now() > end) {
      return true;
    } else {
      pause();
    }
  }
  return false;
}

}  // namespace stiefel
