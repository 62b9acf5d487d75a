#include "server/sessions/server_session.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "server/scheduling/slice.h"
#include "server/sessions/checkpoints/secrets.h"
#include "server/sessions/identity.h"

namespace stiefel::server {
namespace {

constexpr std::size_t max_idle = 2;

/// Returns the initial number of steps between two checkpoints: a millisecond of work, more if the
/// states are large, so that a run of any size fills at most 16 MB a second with checkpoints.
std::int64_t first_spacing(double step_cost, std::size_t bytes) {
  constexpr double nanoseconds_a_byte = 1e9 / 16e6;
  constexpr double least_nanoseconds = 1e6;
  const double work = std::max(least_nanoseconds, static_cast<double>(bytes) * nanoseconds_a_byte);
  return static_cast<std::int64_t>(
      std::bit_floor(static_cast<std::uint64_t>(std::max(work / std::max(step_cost, 1.0), 1.0))));
}

/// Fields with more numbers are not checked: they repeat the state or cost more than the session.
constexpr int largest_checked = Scene::max_dimension * Scene::max_dimension;

std::optional<Overflow> find_overflow(const Simulation& simulation) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < simulation.fields().size(); ++i) {
    const Field& field = simulation.fields()[i];
    if (field.size() > largest_checked) continue;
    numbers.resize(static_cast<std::size_t>(field.size()));
    simulation.write(i, numbers);
    const auto bad = std::ranges::find_if(numbers, [](double x) { return !std::isfinite(x); });
    if (bad != numbers.end()) return Overflow{field.name, *bad};
  }
  return std::nullopt;
}

/// Up to this dimension the price of a step is computed from ‖Ω‖. Above it the eigenvalues for ‖Ω‖
/// cost more than a step, and the price is that at h‖Ω‖ = 0.1.
constexpr int largest_with_rate = 64;

bool is_priced_by_rate(const Scene& scene) {
  return scene.dimension() <= largest_with_rate && price_depends_on_rate(scene);
}

/// Returns h‖Ω‖ for a step of the map, with ‖Ω‖ = `rate`.
double h_omega(const Scene& scene, double rate) {
  return std::abs(scene.step()) / scene.substeps() * rate;
}

/// Returns the price of a step of the map for a scene that is not an ensemble. `rate` is ‖Ω‖ at the
/// start, used where the price depends on it.
double step_price_of(const Scene& scene, double rate) {
  return is_priced_by_rate(scene) ? step_price(scene, h_omega(scene, rate)) : step_weight(scene);
}

/// Whether the method chooses its own steps: `adaptive`.
bool chooses_steps(const Scene& scene) {
  const auto& method = scene.description().method;
  return method && method->tolerance;
}

/// Whether the work of a step depends on ‖Ω‖.
bool work_depends_on_rate(const Scene& scene) {
  return is_priced_by_rate(scene) || chooses_steps(scene);
}

/// Returns the predicted number of substeps that `adaptive` tries for one step,
///
///     1 + h‖Ω‖ (c h‖Ω‖ / tolerance)^{1/8},  c = 0.002,
///
/// since the error of a substep of length τ grows like (‖Ω‖τ)⁸. At most 10 000, after which the
/// engine ends a step (Adaptive::most_substeps). c fits the symmetric systems; other systems need
/// 0.3 to 2.2 times as many substeps, a flat ellipsoid twenty times as many.
double predicted_attempts(double h_omega, double tolerance) {
  constexpr double c = 0.002, most = 10000;
  const double attempts = 1 + h_omega * std::pow(c * h_omega / tolerance, 1.0 / 8);
  return attempts <= most ? attempts : most;  // also where it is NaN
}

/// A state, and the lease of its bytes, which ends with the last reference to the state.
struct PricedState {
  MemoryLease memory;
  std::vector<double> numbers;
};

/// Returns the bytes of a state: its numbers, and 192 for the objects around them.
std::uint64_t state_bytes(std::size_t numbers) { return numbers * sizeof(double) + 192; }
/// The bytes of a session without arrays: its strings, fields and lists.
constexpr std::uint64_t session_object = 8 << 10;

/// Returns a state that holds the lease of its bytes.
Saved priced_state(MemoryLease memory, std::vector<double> numbers) {
  const auto priced = std::make_shared<const PricedState>(std::move(memory), std::move(numbers));
  return {priced, &priced->numbers};
}

Saved save(const Simulation& simulation, MemoryLease memory) {
  std::vector<double> numbers(simulation.saved_size());
  simulation.save(numbers);
  return priced_state(std::move(memory), std::move(numbers));
}

}  // namespace

Session::Session(std::string id, Scene scene, std::shared_ptr<const Clock> clock,
                 Resolution resolution, MemoryBudget& memory)
    : memory_(memory),
      id_(std::move(id)),
      scene_(std::move(scene)),
      resolution_(std::move(resolution)),
      identity_(identity_of(scene_.description())),
      clock_(std::move(clock)),
      simulation_bytes_(stiefel::simulation_bytes(scene_)),
      scene_memory_(memory, stiefel::scene_bytes(scene_.description()) + session_object),
      simulations_memory_(memory, 0),
      warnings_(stiefel::warnings(scene_)),
      checkpoints_(1) {
  if (scene_.members().empty()) {
    auto simulation = make();
    set_outline(outline_of(*simulation));
    set_work(scene_, 1, work_depends_on_rate(scene_) ? simulation->rate() : 0);
    overflow_ = find_overflow(*simulation);
    checkpoints_.put(0, save(*simulation, {memory, state_bytes(saved_size_)}));
    idle_.push_back(std::move(simulation));
  } else {
    read_members();
  }
  touch();
}

void Session::set_outline(Outline outline) {
  fields_ = std::move(outline.fields);
  default_fields_ = stiefel::default_fields(scene_, fields_, outline.block_count);
  saved_size_ = outline.saved_size;
  step_cost_ = outline.step_cost;
  direct_ = outline.direct;
  checkpoints_ = Checkpoints(first_spacing(step_cost_, saved_size_ * sizeof(double)));
  spacing_ = checkpoints_.spacing();
}

/// The simulations and states of the members are many times as large as their scenes, so they are
/// not made before the first step.
void Session::read_members() {
  const auto members = scene_.members();
  const Scene first = members.front();
  const bool by_rate = work_depends_on_rate(first);
  double rate = 0;
  set_outline(outline_of(members, [&](const Scene&, const Simulation& member) {
    if (!overflow_) overflow_ = find_overflow(member);
    if (by_rate) rate = std::max(rate, member.rate());
  }));
  set_work(first, members.size(), rate);
}

void Session::set_work(const Scene& one, std::size_t members, double rate) {
  const double priced = is_priced_by_rate(one) ? rate : 0, of_one = step_price_of(one, priced);
  const auto count = static_cast<double>(members);
  if (chooses_steps(one))
    step_work_ =
        count * map_steps() * predicted_attempts(h_omega(one, rate), scene_.tolerance()) * of_one;
  else if (scene_.members().empty())
    step_work_ = map_steps() * of_one;
  else
    step_work_ = map_steps() * ensemble_step_price(one, members, of_one, h_omega(one, priced));
}

std::unique_ptr<Simulation> Session::make() {
  simulations_memory_.grow(simulation_bytes_);
  try {
    return make_simulation(scene_);
  } catch (...) {
    simulations_memory_.shrink(simulation_bytes_);
    throw;
  }
}

std::unique_ptr<Simulation> Session::lease(std::int64_t step) {
  std::unique_ptr<Simulation> simulation;
  Checkpoints::Nearest start;
  {
    const std::lock_guard lock(mutex_);
    start = checkpoints_.nearest(step);
    auto best = idle_.end();
    for (auto it = idle_.begin(); it != idle_.end(); ++it) {
      const std::int64_t at = (*it)->step();
      if (at <= step && at >= start.step && (best == idle_.end() || at > (*best)->step()))
        best = it;
    }
    const bool near = best != idle_.end();
    if (!near && idle_.size() == max_idle) best = idle_.begin();
    if (best != idle_.end()) {
      simulation = std::move(*best);
      idle_.erase(best);
    }
    if (near) return simulation;
  }
  if (start.saved) return at_state(std::move(simulation), start.step, *start.saved);
  discard(std::move(simulation));
  return make();  // at step 0
}

std::unique_ptr<Simulation> Session::at_state(std::unique_ptr<Simulation> simulation,
                                              std::int64_t step, std::span<const double> saved) {
  if (!simulation) simulation = make();
  if (simulation->step() == step) return simulation;
  try {
    simulation->restore(step, saved);
  } catch (...) {
    discard(std::move(simulation));
    throw;
  }
  return simulation;
}

std::unique_ptr<Simulation> Session::lease_at(std::int64_t step, std::span<const double> saved) {
  std::unique_ptr<Simulation> simulation;
  {
    const std::lock_guard lock(mutex_);
    // An idle simulation at that step is in that state: a session is a function of the step.
    auto best = std::ranges::find(idle_, step, [](const auto& one) { return one->step(); });
    if (best == idle_.end()) best = idle_.begin();
    if (best != idle_.end()) {
      simulation = std::move(*best);
      idle_.erase(best);
    }
  }
  return at_state(std::move(simulation), step, saved);
}

void Session::give_back(std::unique_ptr<Simulation> simulation) noexcept {
  cursor_.store(simulation->step(), std::memory_order_relaxed);
  std::unique_ptr<Simulation> dropped;
  try {
    const std::lock_guard lock(mutex_);
    if (idle_.size() == max_idle) {
      dropped = std::move(idle_.front());
      idle_.erase(idle_.begin());
    }
    idle_.push_back(std::move(simulation));
  } catch (const std::exception&) {  // no memory to keep it
    discard(std::move(simulation));
  }
  discard(std::move(dropped));
}

Saved Session::keep(const Simulation& simulation) {
  const std::int64_t step = simulation.step();
  {
    const std::lock_guard lock(mutex_);
    const auto start = checkpoints_.nearest(step);
    if (start.step == step && start.saved) return start.saved;
    if (const auto found = kept_.find(step); found != kept_.end())
      if (Saved saved = found->second.lock()) return saved;
  }
  MemoryLease memory = MemoryLease::if_it_fits(memory_, state_bytes(saved_size_));
  if (!memory) return nullptr;
  Saved saved = save(simulation, std::move(memory));
  const std::lock_guard lock(mutex_);
  std::erase_if(kept_, [](const auto& one) { return one.second.expired(); });
  kept_[step] = saved;
  return saved;
}

std::uint64_t Session::cached_bytes() const {
  const std::lock_guard lock(mutex_);
  return idle_.size() * simulation_bytes_ + checkpoints_.evictable() * state_bytes(saved_size_);
}

void Session::evict() {
  std::vector<std::unique_ptr<Simulation>> dropped;
  {
    const std::lock_guard lock(mutex_);
    dropped = std::exchange(idle_, {});
    checkpoints_.evict();
  }
  for (auto& simulation : dropped) discard(std::move(simulation));
}

void Session::deposit(const Simulation& simulation) {
  const std::int64_t step = simulation.step();
  {
    const std::lock_guard lock(mutex_);
    if (!checkpoints_.wants(step)) return;
  }
  MemoryLease memory = MemoryLease::if_it_fits(memory_, state_bytes(saved_size_));
  if (!memory) return;  // a checkpoint is not worth dropping another cache
  Saved saved = save(simulation, std::move(memory));
  {
    const std::lock_guard lock(mutex_);
    checkpoints_.put(step, std::move(saved));
    spacing_ = checkpoints_.spacing();
  }
  tell_log();
}

void Session::adopt(std::int64_t step, std::vector<double> saved) {
  MemoryLease memory(memory_, state_bytes(saved.size()));
  Saved priced = priced_state(std::move(memory), std::move(saved));
  const std::lock_guard lock(mutex_);
  checkpoints_.adopt(step, std::move(priced));
  spacing_ = checkpoints_.spacing();
}

void Session::adopt_if_it_fits(std::int64_t step, std::span<const double> saved) {
  MemoryLease memory = MemoryLease::if_it_fits(memory_, state_bytes(saved.size()));
  if (!memory) return;
  Saved priced = priced_state(std::move(memory), {saved.begin(), saved.end()});
  const std::lock_guard lock(mutex_);
  checkpoints_.adopt(step, std::move(priced), false);
  spacing_ = checkpoints_.spacing();
}

void Session::tell_log() {
  if (log_ && !reported_to_log_.exchange(true)) log_->cached(weak_from_this());
}

std::vector<std::int64_t> Session::cached_steps() const {
  const std::lock_guard lock(mutex_);
  auto steps = checkpoints_.steps();
  if (steps.empty() || steps.front() > 0) steps.insert(steps.begin(), 0);
  return steps;
}

}  // namespace stiefel::server
