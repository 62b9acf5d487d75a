#include "server/sessions/server_session.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "server/scheduling/slice.h"

namespace stiefel::server {
namespace {

/// Returns the initial number of steps between two checkpoints: a millisecond of work, more if the
/// states are large, so that a second of one core's work fills at most 16 MB with checkpoints.
/// Where cores may share a step, from 0.1 ms on, at most 2 MB, because one core alone writes a
/// checkpoint.
std::int64_t first_spacing(double step_cost, std::size_t bytes) {
  constexpr double least_nanoseconds = 1e6, of_shared_step = 1e5;
  const double bytes_a_nanosecond = (step_cost < of_shared_step ? 16e6 : 2e6) / 1e9;
  const double work = std::max(least_nanoseconds, static_cast<double>(bytes) / bytes_a_nanosecond);
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

/// A state, and its bytes of the budget, which go back with the last reference to the state.
struct ReservedState {
  MemoryLease memory;
  std::vector<double> numbers;
};

/// Returns the bytes of a state: its numbers, and 192 for the objects around them.
std::uint64_t state_bytes(std::size_t numbers) { return numbers * sizeof(double) + 192; }
/// The bytes of a session without arrays: its strings, fields and lists.
constexpr std::uint64_t session_object = 8 << 10;

Saved reserved_state(MemoryLease memory, std::vector<double> numbers) {
  const auto state = std::make_shared<const ReservedState>(std::move(memory), std::move(numbers));
  return {state, &state->numbers};
}

Saved save(const Simulation& simulation, MemoryLease memory) {
  std::vector<double> numbers(simulation.saved_size());
  simulation.save(numbers);
  return reserved_state(std::move(memory), std::move(numbers));
}

}  // namespace

Session::Session(Scene scene, MemoryBudget& memory)
    : memory_(memory),
      scene_(std::move(scene)),
      identity_(identity_of(scene_.description())),
      simulation_bytes_(stiefel::simulation_bytes(scene_)),
      scene_memory_(memory, stiefel::scene_bytes(scene_.description()) + session_object),
      warnings_(stiefel::warnings(scene_)),
      checkpoints_(1) {
  double rate = 0;
  std::optional<bool> by_rate;  // the same for all members
  const auto look_at = [&](const Scene& one, const Simulation& simulation) {
    if (!overflow_) overflow_ = find_overflow(simulation);
    if (!by_rate) by_rate = work_depends_on_rate(one);
    if (*by_rate) rate = std::max(rate, simulation.rate());
  };
  const auto members = scene_.members();
  SimulationPtr simulation;
  if (members.empty()) {
    simulation = make();
    outline_ = outline_of(*simulation);
    look_at(scene_, *simulation);
    set_work(scene_, 1, rate);
  } else {
    // The simulations and states of the members are many times as large as their scenes, so they
    // are not made before the first step.
    outline_ = outline_of(scene_, look_at);
    set_work(members.front(), members.size(), rate);
  }
  default_fields_ = stiefel::default_fields(scene_, fields(), outline_.block_count);
  checkpoints_ = Checkpoints(first_spacing(step_cost(), saved_size() * sizeof(double)));
  spacing_ = checkpoints_.spacing();
  if (!simulation) return;
  checkpoints_.put(0, save(*simulation, {memory, state_bytes(saved_size())}));
  idle_.back() = std::move(simulation);
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
    step_work_ = map_steps() * ensemble_step_price(one, members, of_one);
}

SimulationPtr Session::make() {
  FreeSimulation reserved{MemoryLease(memory_, simulation_bytes_)};
  return {make_simulation(scene_).release(), std::move(reserved)};
}

SimulationPtr Session::take(SimulationPtr& one) {
  SimulationPtr taken = std::move(one);
  if (&one == &idle_.back()) idle_.back() = std::move(idle_.front());
  return taken;
}

SimulationPtr Session::acquire(std::int64_t step, const Saved& saved) {
  SimulationPtr simulation;
  Checkpoints::Nearest start{step, saved};
  {
    const std::lock_guard lock(mutex_);
    if (!saved) start = checkpoints_.nearest(step);
    SimulationPtr* best = nullptr;
    for (SimulationPtr& one : idle_)
      if (one && start.step <= one->step() && one->step() <= step &&
          (!best || one->step() > (*best)->step()))
        best = &one;
    if (best) return take(*best);
    if (idle_.front()) simulation = take(idle_.front());
  }
  if (!start.saved) {  // step 0
    simulation = {};
    return make();
  }
  if (!simulation) simulation = make();
  if (simulation->step() != start.step) simulation->restore(start.step, *start.saved);
  return simulation;
}

void Session::release(SimulationPtr simulation) noexcept {
  cursor_.store(simulation->step(), std::memory_order_relaxed);
  SimulationPtr dropped;  // after the lock
  const std::lock_guard lock(mutex_);
  dropped = std::move(idle_.front());
  idle_.front() = std::move(idle_.back());
  idle_.back() = std::move(simulation);
}

Saved Session::snapshot(const Simulation& simulation) {
  const std::int64_t step = simulation.step();
  {
    const std::lock_guard lock(mutex_);
    const auto start = checkpoints_.nearest(step);
    if (start.step == step && start.saved) return start.saved;
    if (const auto found = snapshots_.find(step); found != snapshots_.end())
      if (Saved saved = found->second.lock()) return saved;
  }
  MemoryLease memory = MemoryLease::if_it_fits(memory_, state_bytes(saved_size()));
  if (!memory) return nullptr;
  Saved saved = save(simulation, std::move(memory));
  const std::lock_guard lock(mutex_);
  std::erase_if(snapshots_, [](const auto& one) { return one.second.expired(); });
  snapshots_[step] = saved;
  return saved;
}

std::uint64_t Session::cached_bytes() const {
  const std::lock_guard lock(mutex_);
  const auto idle = static_cast<std::uint64_t>(
      std::ranges::count_if(idle_, [](const auto& one) { return one != nullptr; }));
  return idle * simulation_bytes_ + checkpoints_.evictable() * state_bytes(saved_size());
}

void Session::evict() {
  std::array<SimulationPtr, 2> dropped;  // after the lock
  const std::lock_guard lock(mutex_);
  dropped = std::exchange(idle_, {});
  checkpoints_.evict();
}

void Session::put_checkpoint(const Simulation& simulation) {
  const std::int64_t step = simulation.step();
  {
    const std::lock_guard lock(mutex_);
    if (!checkpoints_.wants(step)) return;
  }
  MemoryLease memory = MemoryLease::if_it_fits(memory_, state_bytes(saved_size()));
  if (!memory) return;  // a checkpoint is not worth dropping another cache
  Saved saved = save(simulation, std::move(memory));
  const std::lock_guard lock(mutex_);
  checkpoints_.put(step, std::move(saved));
  spacing_ = checkpoints_.spacing();
  has_new_state_ = true;
}

void Session::restore_checkpoint(std::int64_t step, std::vector<double> saved, bool of_client) {
  const std::uint64_t bytes = state_bytes(saved.size());
  MemoryLease memory =
      of_client ? MemoryLease(memory_, bytes) : MemoryLease::if_it_fits(memory_, bytes);
  if (!memory) return;
  Saved state = reserved_state(std::move(memory), std::move(saved));
  const std::lock_guard lock(mutex_);
  checkpoints_.restore(step, std::move(state), of_client);
  spacing_ = checkpoints_.spacing();
  if (of_client) has_new_state_ = true;
}

std::optional<Checkpoints::Nearest> Session::take_new_state() {
  if (!has_new_state_.exchange(false)) return std::nullopt;
  const std::lock_guard lock(mutex_);
  auto last = checkpoints_.nearest(max_step);
  return last.step > 0 ? std::optional(std::move(last)) : std::nullopt;
}

std::vector<std::int64_t> Session::cached_steps() const {
  const std::lock_guard lock(mutex_);
  auto steps = checkpoints_.steps();
  if (steps.empty() || steps.front() > 0) steps.insert(steps.begin(), 0);
  return steps;
}

}  // namespace stiefel::server
