#include "stiefel/crew.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

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
  void limit(std::size_t threads) {
    const std::lock_guard lock(mutex_);
    limit_.store(std::max<std::size_t>(threads, 1), std::memory_order_relaxed);
  }

  std::size_t threads_at_hand() override { return limit_.load(std::memory_order_relaxed); }

  void run(std::size_t count, double, Item item, void* context) override {
    thread_local Leader leader(*this);
    if (count > 1 && busy_.load(std::memory_order_relaxed) + 1 < threads_at_hand())
      call(leader, count - 1);
    leader.team.run(count, 1, item, context);
  }

 private:
  /// A thread that has divided its work.
  struct Leader {
    explicit Leader(OwnCrew& owner) : crew(owner) {}
    ~Leader() { crew.forget(*this); }

    OwnCrew& crew;
    Team team;
    // Guarded by the crew's mutex.
    std::size_t wanted = 0, helpers = 0;
    bool listed = false;
  };

  void call(Leader& leader, std::size_t wanted) {
    const std::lock_guard lock(mutex_);
    leader.wanted = wanted;
    if (!std::exchange(leader.listed, true)) leaders_.push_back(&leader);
    const std::size_t most = threads_at_hand() - 1;
    while (threads_.size() < std::min(most, busy_ + wanted)) {
      try {
        threads_.emplace_back([this] { work(); });
      } catch (const std::exception&) {  // the leader works alone
        break;
      }
    }
    for (std::size_t k = leader.helpers; k < std::min(wanted, most); ++k) wake_.notify_one();
  }

  void forget(Leader& leader) {
    std::unique_lock lock(mutex_);
    leader.wanted = 0;
    std::erase(leaders_, &leader);
    left_.wait(lock, [&] { return leader.helpers == 0; });
  }

  [[noreturn]] void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      Leader* leader = busy_ + 1 < threads_at_hand() ? next() : nullptr;
      if (!leader) {
        wake_.wait(lock);
        continue;
      }
      ++busy_;
      ++leader->helpers;
      lock.unlock();
      leader->team.help([] { return false; }, [] { return 0.0; });
      lock.lock();
      --busy_;
      leader->wanted = std::min(leader->wanted, --leader->helpers);
      left_.notify_all();
    }
  }

  /// Returns the leader with the fewest helpers of those that want more.
  Leader* next() const {
    Leader* next = nullptr;
    for (Leader* leader : leaders_)
      if (leader->helpers < leader->wanted && (!next || leader->helpers < next->helpers))
        next = leader;
    return next;
  }

  std::atomic<std::size_t> limit_ = std::max(1U, std::thread::hardware_concurrency());
  std::atomic<std::size_t> busy_ = 0;  // threads that help
  std::mutex mutex_;
  std::condition_variable wake_, left_;
  std::vector<Leader*> leaders_;
  std::vector<std::thread> threads_;
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
