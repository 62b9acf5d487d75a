#include "stiefel/summary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "engine/simulation/stepping/invariant_list.h"
#include "engine/simulation/summary/energy_of_body.h"
#include "stiefel/catalogue.h"
#include "stiefel/diagnosis.h"
#include "stiefel/simulation.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using testing::random_scene;
using testing::RandomBody;

Scene resolved(SceneDescription description) {
  return Scene::resolve(std::move(description)).value();
}

Summary prepare(const Scene& scene, SummaryDescription what) {
  auto summary = Summary::prepare(scene, std::move(what));
  if (!summary) throw std::logic_error(summary.error().front().rule);
  return *std::move(summary);
}

/// All of a summary as bytes, and its events and states.
struct Done {
  std::vector<SummaryArray> statistics;
  std::vector<Event> events;
  std::vector<StateAtTime> states;
  RunStatus status;

  const SummaryArray& operator[](std::string_view name) const {
    return *std::ranges::find(statistics, name, &SummaryArray::name);
  }
  void take(Summary& summary) {
    std::ranges::move(summary.take_events(), std::back_inserter(events));
    std::ranges::move(summary.take_states(), std::back_inserter(states));
  }
  std::vector<std::uint64_t> bits() const {
    std::vector<std::uint64_t> all;
    const auto number = [&](double x) { all.push_back(std::bit_cast<std::uint64_t>(x)); };
    for (const auto& array : statistics) {
      std::ranges::for_each(array.numbers, number);
      for (const auto count : array.counts) all.push_back(static_cast<std::uint64_t>(count));
    }
    for (const Event& event : events) {
      all.insert(all.end(), {event.event, static_cast<std::uint64_t>(event.step), event.member});
      number(event.fraction);
      number(event.time);
      std::ranges::for_each(event.fields, number);
    }
    for (const StateAtTime& state : states) {
      all.push_back(static_cast<std::uint64_t>(state.step));
      std::ranges::for_each(state.fields, number);
    }
    return all;
  }
};

Done finish(Summary& summary, std::int64_t steps = 1000) {
  Done done;
  while (!summary.done()) {
    summary.advance(steps, summary.description().to);
    done.take(summary);
  }
  done.statistics = summary.statistics();
  done.status = summary.status();
  return done;
}

Done run(const Scene& scene, const SummaryDescription& what, std::int64_t steps = 1000) {
  Summary summary = prepare(scene, what);
  return finish(summary, steps);
}

const std::vector<Statistic> every_statistic = {
    Statistic::last, Statistic::min,          Statistic::max,  Statistic::mean,
    Statistic::rms,  Statistic::sign_changes, Statistic::drift};

SummaryDescription everything(std::int64_t from, std::int64_t to, std::int64_t every) {
  SummaryDescription what{.from = from, .to = to, .every = every};
  what.quantities = {{"energy", every_statistic, {0, 0.3, 1}, {}},
                     {"M", every_statistic, {0.5}, {-2, -0.5, 0, 0.5, 2}},
                     {"casimirs", {Statistic::drift, Statistic::last}, {}, {}},
                     {"quaternion", {Statistic::last}, {}, {}}};
  return what;
}

/// m_2 of a body.
EventDescription crossing(Direction direction = Direction::both) {
  EventDescription event{.field = "M", .coefficients = std::vector<double>(9, 0)};
  event.coefficients[2] = 1;
  event.direction = direction;
  return event;
}

/// A top with I = (1, 2, 3) and m = (m_1, 0, m_3), which circles the third axis: m_2 = 0 at the
/// multiples of 2K/p, with K the complete elliptic integral by the arithmetic-geometric mean.
constexpr long double m1 = 0.5L, m3 = 1.5L;

SceneDescription top(double step, const std::string& method, int order = 0) {
  SceneDescription scene;
  scene.system = "rigid_body";
  scene.step = step;
  scene.method.emplace().name = method;
  if (order > 0) scene.method->order = order;
  scene.inertia = {2, 1, 0};
  scene.initial["Q"] = RowMatrix(RowMatrix::Identity(3, 3));
  RowMatrix M(3, 3);
  M << 0, -static_cast<double>(m3), 0, static_cast<double>(m3), 0, -static_cast<double>(m1), 0,
      static_cast<double>(m1), 0;
  scene.initial["M"] = M;
  return scene;
}

long double half_period() {
  const long double p = m3 / 3, k2 = 3 * m1 * m1 / (m3 * m3);  // of (I3 - I2)(I3 - I1)/(I1 I2) = 1
  long double a = 1, b = std::sqrt(1 - k2);
  for (int i = 0; i < 10; ++i) {
    const long double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return std::acos(-1.0L) / a / p;
}

/// The zeros of m_2 up to `count`, both ways, rising and falling.
Done zeros_of_the_top(const Scene& scene, int count) {
  SummaryDescription what{
      .to = static_cast<std::int64_t>((count + 0.5L) * half_period() / scene.step())};
  what.events = {crossing(), crossing(Direction::rising), crossing(Direction::falling)};
  what.fields = {"M"};
  return run(scene, what);
}

void expect_the_closed_form(const Done& done, int count) {
  int found = 0, up = 0, down = 0;
  for (std::size_t i = 0; i + 1 < done.events.size(); i += 2) {
    const Event &both = done.events[i], &one_way = done.events[i + 1];
    const auto exact = static_cast<double>(++found * half_period());
    EXPECT_LT(std::abs(both.time - exact), 1e-12 * exact) << found;
    EXPECT_LT(std::abs(both.fields[2]), 1e-13);
    EXPECT_EQ(both.event, 0);
    EXPECT_EQ(one_way.time, both.time);
    EXPECT_EQ(one_way.event, found % 2 == 1 ? done.events[1].event : 3 - done.events[1].event);
    (one_way.event == 1 ? up : down)++;
  }
  EXPECT_EQ(found, count);
  EXPECT_EQ(done.events.size(), 2 * static_cast<std::size_t>(count));
  EXPECT_LE(std::abs(up - down), 1);
}

TEST(Events, OfATopAreWhereTheClosedFormHasThem) {
  expect_the_closed_form(zeros_of_the_top(resolved(top(0.05, "preprocessed_variational", 10)), 50),
                         50);
  expect_the_closed_form(zeros_of_the_top(resolved(top(0.3, "exact")), 50), 50);
}

TEST(Events, RiseWhereTheValueGoesFromNegativeToPositive) {
  const Scene scene = resolved(top(0.1, "rk4"));
  const Done done = zeros_of_the_top(scene, 5);
  for (const Event& event : done.events) {
    if (event.event == 0) continue;
    const auto simulation = make_simulation(scene);
    simulation->advance(event.step);
    const double before = simulation->get("M")(0, 2);
    simulation->advance(1);
    const double after = simulation->get("M")(0, 2);
    EXPECT_EQ(before < 0 && after >= 0, event.event == 1);
    EXPECT_EQ(before > 0 && after <= 0, event.event == 2);
    EXPECT_LE(scene.time(event.step), event.time);
    EXPECT_LE(event.time, scene.time(event.step + 1));
  }
}

/// On states of any method, any system with a real field: the function is 0 to rounding there.
TEST(Events, AreFoundOnTheStatesOfEveryMethod) {
  for (const auto& system : catalogue().systems)
    for (const auto& method : system.methods) {
      const int N = method.takes && !method.takes(Eigen::VectorXd::Ones(4)) ? 3 : 4;
      const auto given =
          testing::any_scene(std::string(system.name), std::string(method.method), 3, 0.05, N);
      const Scene scene = resolved(given);
      const Field field = make_simulation(scene)->fields().front();
      if (field.complex) continue;
      SummaryDescription what{.to = 100, .fields = {field.name}};
      const auto size = static_cast<std::size_t>(field.size());
      for (std::size_t k = 0; k < size; ++k) {
        EventDescription& event = what.events.emplace_back(field.name);
        event.coefficients.resize(size);
        event.coefficients[k] = 1;
      }
      const Done done = run(scene, what);
      EXPECT_GT(done.events.size(), 0) << system.name << " " << method.method;
      for (const Event& event : done.events) {
        if (system.discrete)
          EXPECT_EQ(event.fraction, 1);
        else
          // A method that chooses its own steps is continuous in them to its tolerance only.
          EXPECT_LT(std::abs(event.fields[event.event]), method.method == "adaptive" ? 1e-9 : 1e-13)
              << system.name << " " << method.method << " step " << event.step;
      }
    }
}

TEST(Events, EndAtTheirLimitAndEndTheMotion) {
  const Scene scene = resolved(top(0.1, "preprocessed_variational"));
  SummaryDescription what{.to = 2000};
  what.events = {crossing()};
  what.quantities = {{"energy", {Statistic::mean}, {}, {}}, {"M", {Statistic::last}, {}, {}}};
  const Done all = run(scene, what);
  ASSERT_GT(all.events.size(), 5);
  what.events[0].limit = 3;
  const Done three = run(scene, what);
  EXPECT_EQ(three.events.size(), 3);
  EXPECT_EQ(three["last_step"].counts.front(), 2000);
  what.events[0].terminal = true;
  const Done ended = run(scene, what);
  ASSERT_EQ(ended.events.size(), 3);
  EXPECT_EQ(ended.events[2].time, all.events[2].time);
  EXPECT_EQ(ended["last_step"].counts.front(), all.events[2].step);
  EXPECT_EQ(ended["ended_by"].counts.front(), 0);
  EXPECT_EQ(ended["samples"].counts.front(), all.events[2].step + 1);
  EXPECT_TRUE(ended.status.reached());
  const auto simulation = make_simulation(scene);
  simulation->advance(all.events[2].step);
  EXPECT_EQ(ended["M.last"].numbers[2], simulation->get("M")(0, 2));
}

/// The values of a field at the samples.
std::vector<std::vector<double>> samples(const Scene& scene, std::string_view name,
                                         const SummaryDescription& what) {
  const auto simulation = make_simulation(scene);
  simulation->advance(what.from);
  std::vector<std::vector<double>> all;
  for (std::int64_t step = what.from;; step = std::min(step + what.every, what.to)) {
    simulation->advance(step - simulation->step());
    const RowMatrix value = simulation->get(name);
    all.emplace_back(value.data(), value.data() + value.size());
    if (step == what.to) return all;
  }
}

TEST(Summary, IsThatOfTheSamples) {
  const Scene scene = random_scene(3, 4, 0.2, "rk4");
  const SummaryDescription what = everything(5, 1002, 7);
  const Done done = run(scene, what);
  const auto M = samples(scene, "M", what);
  const auto start = make_simulation(scene)->get("M");
  EXPECT_EQ(done["samples"].counts.front(), static_cast<std::int64_t>(M.size()));
  for (std::size_t i = 0; i < 9; ++i) {
    std::vector<double> x;
    for (const auto& sample : M) x.push_back(sample[i]);
    EXPECT_EQ(done["M.last"].numbers[i], x.back());
    EXPECT_EQ(done["M.min"].numbers[i], std::ranges::min(x));
    EXPECT_EQ(done["M.max"].numbers[i], std::ranges::max(x));
    const auto n = static_cast<long double>(x.size());
    long double sum = 0, squares = 0, drift = 0;
    std::int64_t changes = 0, sign = 0;
    std::vector<std::int64_t> bins(4);
    for (const double value : x) {
      sum += value;
      squares += static_cast<long double>(value) * value;
      drift = std::max<long double>(drift, std::abs(value - start(i / 3, i % 3)));
      const int now = (value > 0) - (value < 0);
      if (now != 0 && sign != 0 && now != sign) ++changes;
      if (now != 0) sign = now;
      for (std::size_t bin = 0; bin < 4; ++bin) {
        const auto& e = what.quantities[1].edges;
        if (value >= e[bin] && (value < e[bin + 1] || (bin == 3 && value == e[4]))) ++bins[bin];
      }
    }
    EXPECT_NEAR(done["M.mean"].numbers[i], static_cast<double>(sum / n), 1e-16);
    EXPECT_NEAR(done["M.rms"].numbers[i], static_cast<double>(std::sqrt(squares / n)), 2e-16);
    EXPECT_EQ(done["M.sign_changes"].counts[i], changes);
    EXPECT_EQ(done["M.drift"].numbers[i], static_cast<double>(drift));
    EXPECT_TRUE(std::ranges::equal(std::span(done["M.histogram"].counts).subspan(4 * i, 4), bins));
    std::ranges::sort(x);
    const std::size_t middle = (x.size() - 1) / 2;
    const double median =
        x.size() % 2 == 1 ? x[middle] : x[middle + 1] - (x[middle + 1] - x[middle]) * 0.5;
    EXPECT_EQ(done["M.quantiles"].numbers[i], median);
  }
}

/// Of every invariant the bits of the largest drift that Diagnose has at a sample.
TEST(Summary, HasTheLargestDriftThatDiagnoseHas) {
  for (const char* method : {"rk4", "preprocessed_variational", "exact"})
    for (const int N : {3, 4}) {
      if (N == 4 && std::string_view(method) != "rk4") continue;
      const Scene scene = random_scene(N, 7, 0.2, method);
      SummaryDescription what{.to = 60, .every = 3};
      const std::vector<std::string> names = {"energy", "spatial_momentum", "casimirs"};
      for (const auto& name : names)
        what.quantities.push_back({name, {Statistic::drift, Statistic::last}, {}, {}});
      const Done done = run(scene, what);
      for (const auto& name : names) {
        const auto simulation = make_simulation(scene);
        std::vector<double> largest, last;
        for (std::int64_t step = 0; step <= 60; step += 3) {
          const Diagnosis at = diagnose(scene, *simulation, std::vector{name});
          largest.resize(at.invariants.size());
          last.clear();
          for (std::size_t i = 0; i < largest.size(); ++i) {
            largest[i] = std::max(largest[i], at.invariants[i].drift());
            last.push_back(static_cast<double>(at.invariants[i].value));
          }
          simulation->advance(3);
        }
        EXPECT_EQ(done[name + ".drift"].numbers, largest) << name << " " << method;
        EXPECT_EQ(done[name + ".last"].numbers, last) << name << " " << method;
      }
    }
}

TEST(Summary, ReadsTheEnergyOfABodyWithoutItsList) {
  for (const char* method : {"rk4", "preprocessed_variational", "exact", "variational"}) {
    const Scene scene = random_scene(3, 11, 0.1, method);
    const auto simulation = make_simulation(scene);
    const auto of_list = [&] {
      const std::vector<std::string> only{"energy"};
      InvariantList list(only);
      simulation->invariants(list);
      return list.entries().front().value;
    };
    auto energy = EnergyOfBody::make(scene, *simulation, of_list());
    ASSERT_TRUE(energy) << method;
    for (int k = 0; k < 20; ++k) {
      EXPECT_EQ((*energy)(*simulation), of_list()) << method;
      simulation->advance(1);
    }
  }
  const Scene other = resolved(testing::any_scene("right_rigid_body", "rk4", 1, 0.1, 3));
  EXPECT_FALSE(EnergyOfBody::make(other, *make_simulation(other), 1));
}

SummaryDescription with_all(SummaryDescription what, double step) {
  what.events = {crossing(), crossing(Direction::rising)};
  what.events[1].limit = 2;
  for (const double k : {5.0, 5.25, 17.5, 17.75, 200.0, 300.125}) what.times.push_back(k * step);
  return what;
}

TEST(Summary, DoesNotDependOnHowTheStepsAreDivided) {
  for (const char* method : {"preprocessed_variational", "exact", "rk4"}) {
    const Scene scene = random_scene(3, 4, 0.25, method);
    const auto what = with_all(everything(5, 1002, 7), scene.step());
    const auto whole = run(scene, what, 1'000'000).bits();
    for (const std::int64_t steps : {1, 10, 333}) EXPECT_EQ(run(scene, what, steps).bits(), whole);
  }
}

TEST(Summary, ResumesAtAnyStepWithTheSameBits) {
  const Scene scene = random_scene(3, 4, 0.25, "rk4");
  const auto what = with_all(everything(5, 302, 7), scene.step());
  const auto whole = run(scene, what).bits();
  for (std::int64_t at = 0; at < 302; at += 13) {
    Summary first = prepare(scene, what);
    Done done;
    while (first.step() < at) first.advance(50, at);
    done.take(first);
    Summary second = prepare(scene, what);
    ASSERT_TRUE(second.restore(first.save())) << at;
    EXPECT_EQ(second.step(), first.step());
    EXPECT_EQ(second.save(), first.save());
    Done rest = finish(second);
    std::ranges::move(rest.events, std::back_inserter(done.events));
    std::ranges::move(rest.states, std::back_inserter(done.states));
    done.statistics = rest.statistics;
    EXPECT_EQ(done.bits(), whole) << at;
  }
}

TEST(Summary, DoesNotTakeDamagedBytes) {
  const Scene scene = random_scene(3, 4, 0.25, "rk4");
  const auto what = with_all(everything(5, 302, 7), scene.step());
  Summary first = prepare(scene, what);
  first.advance(100, 100);
  const std::string saved = first.save();
  for (std::size_t length = 0; length < saved.size(); length += 7)
    EXPECT_FALSE(prepare(scene, what).restore(std::string_view(saved).substr(0, length)));
  EXPECT_FALSE(prepare(scene, what).restore(saved + '\0'));
  EXPECT_FALSE(prepare(scene, everything(5, 302, 7)).restore(saved));
}

std::vector<SceneDescription> bodies(int count, const std::string& method, double step) {
  std::vector<SceneDescription> scenes;
  for (int b = 0; b < count; ++b)
    scenes.push_back(
        testing::description(RandomBody(3, 100 + static_cast<unsigned>(b)), step, method));
  return scenes;
}

/// A body whose rk4 ends within 900 steps.
SceneDescription diverging(SceneDescription scene) {
  for (unsigned seed = 1; seed < 100; ++seed)
    for (double rate = 10; rate < 100; rate *= 1.3) {
      RandomBody body(3, seed, 40);
      scene.inertia = {body.lambda.begin(), body.lambda.end()};
      scene.initial["M"] = RowMatrix(body.M * rate);
      const auto simulation = make_simulation(resolved(scene));
      if (!simulation->advance(900).reached() && simulation->step() > 10) return scene;
    }
  throw std::logic_error("none of them diverges");
}

/// Each member has the numbers that it has alone, those that stop early and the others; whatever
/// the threads.
TEST(SummaryOfAnEnsemble, IsOfEachMemberWhatItIsAlone) {
  for (const char* method : {"preprocessed_variational", "rk4", "exact"}) {
    auto scenes = bodies(21, method, 0.3);
    if (method == std::string_view("rk4")) {
      scenes[7] = diverging(scenes[7]);
      scenes[9] = diverging(scenes[9]);
    }
    const Scene ensemble = resolved(testing::ensemble_of(scenes));
    auto what = with_all(everything(3, 900, 11), ensemble.step());
    what.events[1].terminal = method != std::string_view("rk4");
    std::vector<std::uint64_t> bits;
    for (const int threads : {1, 2, 5}) {
      limit_ensemble_threads(threads);
      const Done all = run(ensemble, what, threads == 2 ? 10 : 1000);
      if (bits.empty()) bits = all.bits();
      EXPECT_EQ(all.bits(), bits) << method << " with " << threads << " threads";
    }
    limit_ensemble_threads(2);
    const Done all = run(ensemble, what);
    std::size_t events = 0;
    for (std::size_t b = 0; b < scenes.size(); ++b) {
      const Done one = run(resolved(scenes[b]), what);
      for (std::size_t i = 0; i < one.statistics.size(); ++i) {
        const auto &mine = one.statistics[i], &theirs = all.statistics[i];
        const std::size_t each = mine.numbers.size(), counts = mine.counts.size();
        for (std::size_t k = 0; k < each; ++k)
          EXPECT_EQ(std::bit_cast<std::uint64_t>(theirs.numbers[b * each + k]),
                    std::bit_cast<std::uint64_t>(mine.numbers[k]))
              << method << " " << mine.name << " of member " << b;
        for (std::size_t k = 0; k < counts; ++k)
          EXPECT_EQ(theirs.counts[b * counts + k], mine.counts[k]) << mine.name;
      }
      std::size_t at = 0;
      for (const Event& event : all.events) {
        if (event.member != b) continue;
        ASSERT_LT(at, one.events.size());
        EXPECT_EQ(event.time, one.events[at].time);
        EXPECT_EQ(event.fields, one.events[at++].fields);
      }
      EXPECT_EQ(at, one.events.size());
      events += at;
    }
    EXPECT_EQ(events, all.events.size());
    if (method != std::string_view("rk4")) continue;
    EXPECT_EQ(all.status.outcome, Outcome::not_finite);
    EXPECT_EQ(std::ranges::count_if(all["outcome"].counts, [](auto o) { return o != 0; }), 2);
  }
}

TEST(SummaryOfAnEnsemble, OverTheMembersIsOfAllTheirSamples) {
  const auto scenes = bodies(13, "preprocessed_variational", 0.2);
  const Scene ensemble = resolved(testing::ensemble_of(scenes));
  SummaryDescription what{.to = 200, .every = 5};
  what.quantities = {
      {"M", {Statistic::max, Statistic::mean, Statistic::sign_changes}, {0.25}, {-1, 0, 1}, true}};
  const Done all = run(ensemble, what);
  what.quantities[0].over_members = false;
  std::vector<double> values, largest(9, -1e300);
  long double sum = 0;
  std::int64_t changes = 0, below = 0;
  for (const auto& scene : scenes) {
    const Done one = run(resolved(scene), what);
    for (std::size_t i = 0; i < 9; ++i) largest[i] = std::max(largest[i], one["M.max"].numbers[i]);
    changes += one["M.sign_changes"].counts[1];
    below += one["M.histogram"].counts[2];
    for (const auto& sample : samples(resolved(scene), "M", what)) {
      values.push_back(sample[1]);
      sum += sample[1];
    }
  }
  EXPECT_EQ(all["M.max"].numbers, largest);
  EXPECT_EQ(all["M.sign_changes"].counts[1], changes);
  EXPECT_EQ(all["M.histogram"].counts[2], below);
  EXPECT_NEAR(all["M.mean"].numbers[1],
              static_cast<double>(sum / static_cast<long double>(values.size())), 1e-16);
  std::ranges::sort(values);
  const double position = 0.25 * static_cast<double>(values.size() - 1);
  const auto at = static_cast<std::size_t>(position);
  EXPECT_GE(all["M.quantiles"].numbers[1], values[at]);
  EXPECT_LE(all["M.quantiles"].numbers[1], values[at + 1]);
}

TEST(SummaryOfAnEnsemble, ResumesWithTheSameBits) {
  auto scenes = bodies(11, "rk4", 0.3);
  scenes[7] = diverging(scenes[7]);
  const Scene ensemble = resolved(testing::ensemble_of(scenes));
  const auto what = everything(0, 900, 10);
  const auto whole = run(ensemble, what).bits();
  for (const std::int64_t at : {0, 5, 450, 899}) {
    Summary first = prepare(ensemble, what);
    while (first.step() < at) first.advance(100, at);
    Summary second = prepare(ensemble, what);
    ASSERT_TRUE(second.restore(first.save()));
    EXPECT_EQ(finish(second).bits(), whole) << at;
  }
}

/// At a state its bits; between two states what a shorter step makes, whose error is the method's.
TEST(Times, AreOfTheMethodItself) {
  const auto error_at = [](double step) {
    const Scene scene = random_scene(3, 5, step, "rk4");
    SummaryDescription what{.to = 40};
    what.times = {0, scene.time(7), scene.time(7) + 0.3 * step, scene.time(40)};
    what.fields = {"M"};
    const Done done = run(scene, what);
    EXPECT_EQ(done.states.size(), 4);
    const auto simulation = make_simulation(scene);
    simulation->advance(7);
    const RowMatrix M = simulation->get("M");
    EXPECT_TRUE(std::ranges::equal(done.states[1].fields, std::span(M.data(), 9)));
    EXPECT_EQ(done.states[1].step, 7);
    EXPECT_EQ(done.states[2].step, 7);
    const Scene exact = random_scene(3, 5, what.times[2], "exact");
    const auto there = make_simulation(exact);
    there->advance(1);
    const RowMatrix truth = there->get("M");
    double error = 0;
    for (std::size_t i = 0; i < 9; ++i)
      error = std::max(error, std::abs(done.states[2].fields[i] - truth.data()[i]));
    return error;
  };
  const double coarse = error_at(0.2), fine = error_at(0.1);
  EXPECT_LT(coarse, 1e-3);
  EXPECT_GT(coarse / fine, 8);
  EXPECT_GT(fine, 0);
}

TEST(Times, OfAClosedFormAreItsStates) {
  const Scene scene = random_scene(3, 5, 0.25, "exact");
  SummaryDescription what{.to = std::int64_t{1} << 40, .every = std::int64_t{1} << 40};
  what.times = {0.1, 1e6 + 0.1, scene.time(what.to)};
  const Done done = run(scene, what);
  ASSERT_EQ(done.states.size(), 3);
  for (const StateAtTime& state : done.states) {
    const auto there = make_simulation(random_scene(3, 5, state.time, "exact"));
    there->advance(1);
    std::vector<double> truth(18);
    there->write(0, std::span(truth).first(9));
    there->write(1, std::span(truth).last(9));
    EXPECT_EQ(state.fields, truth) << state.time;
  }
}

TEST(Times, GoBackwardsWithTheStep) {
  const Scene scene = random_scene(3, 5, -0.25, "preprocessed_variational");
  SummaryDescription what{.to = 20};
  what.times = {0, -0.1, -2.6, -5};
  EXPECT_EQ(run(scene, what).states.size(), 4);
  what.times = {-2.6, -0.1};
  EXPECT_FALSE(Summary::prepare(scene, what));
}

TEST(Summary, RefusesWhatIsWrongBeforeAnythingMoves) {
  const Scene scene = random_scene(3, 5, 0.1, "rk4");
  const auto refused = [&](auto change) {
    SummaryDescription what = with_all(everything(0, 400, 1), scene.step());
    change(what);
    const auto summary = Summary::prepare(scene, what);
    return summary ? std::string("taken") : summary.error().front().field;
  };
  using W = SummaryDescription;
  EXPECT_EQ(refused([](W&) {}), "taken");
  EXPECT_EQ(refused([](W& w) { w.quantities[0].name = "enrgy"; }), "quantities[0].name");
  EXPECT_EQ(refused([](W& w) { w.quantities[2].name = "energy"; }), "quantities[2].name");
  EXPECT_EQ(refused([](W& w) { w.quantities[0].quantiles = {1.5}; }), "quantities[0].quantiles");
  EXPECT_EQ(refused([](W& w) { w.quantities[0].edges = {1}; }), "quantities[0].edges");
  EXPECT_EQ(refused([](W& w) { w.quantities[0].edges = {1, 1}; }), "quantities[0].edges");
  EXPECT_EQ(refused([](W& w) { w.quantities[0].over_members = true; }),
            "quantities[0].over_members");
  EXPECT_EQ(refused([](W& w) { w.quantities[3].statistics.clear(); }), "quantities[3].statistics");
  EXPECT_EQ(refused([](W& w) { w.to = 1 << 22; }), "quantities");
  EXPECT_EQ(refused([](W& w) { w.events[0].field = "energy"; }), "events[0].field");
  EXPECT_EQ(refused([](W& w) { w.events[0].coefficients.pop_back(); }), "events[0].coefficients");
  EXPECT_EQ(refused([](W& w) { w.events[0].coefficients.assign(9, 0); }), "events[0].coefficients");
  EXPECT_EQ(refused([](W& w) { w.events[0].level = INFINITY; }), "events[0]");
  EXPECT_EQ(refused([](W& w) { w.events.resize(65, w.events[0]); }), "events");
  EXPECT_EQ(refused([](W& w) { w.fields = {"Q", "Q"}; }), "fields[1]");
  EXPECT_EQ(refused([](W& w) { w.times = {1, 0.5}; }), "times[1]");
  EXPECT_EQ(refused([](W& w) { w.times = {-1}; }), "times[0]");
  EXPECT_EQ(refused([](W& w) { w.times = {NAN}; }), "times[0]");
  const Scene discrete = random_scene(3, 5, 0.1, "");
  SummaryDescription what{.to = 10};
  what.times = {0.1};
  EXPECT_EQ(Summary::prepare(discrete, what).error().front().field, "times");
}

TEST(Summary, EndsWhenItIsAskedToStop) {
  const Scene scene = random_scene(3, 5, 0.1, "rk4");
  Summary summary = prepare(scene, everything(0, 1000, 1));
  summary.advance(10, 1000);
  EXPECT_FALSE(summary.interrupted());
  std::stop_source stop;
  stop.request_stop();
  summary.advance(10, 1000, stop.get_token());
  EXPECT_TRUE(summary.interrupted());
  EXPECT_FALSE(summary.done());
  summary.cancel();
  EXPECT_TRUE(summary.done());
  EXPECT_EQ(summary.status().outcome, Outcome::cancelled);
}

}  // namespace
}  // namespace stiefel
