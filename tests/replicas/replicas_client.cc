// A client of servers that are killed, and the embedded simulation that it compares every state
// with.
//
//   replicas_client states FOLDER FROM COUNT         writes scene.json and the states FROM to
//                                                    FROM + COUNT - 1, one after another
//   replicas_client checkpoint ADDRESS FOLDER FROM   asks a server for a checkpoint of state FROM
//   replicas_client run ADDRESS FOLDER FROM COUNT SECONDS
//                                                    a thread a kind of call; prints a line of JSON
#include <google/protobuf/util/json_util.h>

#include <atomic>
#include <fstream>
#include <iostream>
#include <iterator>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "server/convert/convert.h"
#include "server/convert/resolve.h"
#include "stiefel/client/client.h"
#include "stiefel/simulation.h"
#include "tests/server/scene_cases.h"

namespace stiefel::client {
namespace {

using Time = std::chrono::steady_clock;

constexpr std::size_t state_bytes = 18 * sizeof(double);  // Q and M

void append_state(const Simulation& simulation, std::string& bytes) {
  for (std::size_t i = 0; i < simulation.block_count(); ++i) {
    std::vector<double> values(static_cast<std::size_t>(simulation.fields()[i].size()));
    simulation.write(i, values);
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  }
}

/// Without negative zeros, which JSON does not keep.
SceneDescription description() {
  SceneDescription scene = test::description();
  for (auto& [name, block] : scene.initial) block.values.array() += 0.0;
  return scene;
}

v1::Scene wire_scene() {
  v1::Scene scene;
  server::to_proto(description(), &scene);
  return scene;
}

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::ssize(bytes));
}

void write_states(const std::string& folder, std::int64_t from, std::int64_t count) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  std::string json;
  if (!google::protobuf::util::MessageToJsonString(wire_scene(), &json, options).ok())
    throw std::runtime_error("the scene is no JSON");
  write(folder + "/scene.json", json);
  std::string states;
  const auto simulation = make_simulation(Scene::resolve(description()).value());
  simulation->advance(from);
  for (std::int64_t i = 0; i < count; ++i, simulation->advance(1))
    append_state(*simulation, states);
  write(folder + "/states", states);
}

/// What the threads of a run share.
class Run {
 public:
  Run(const std::string& address, const std::string& folder, std::int64_t from, std::int64_t count)
      : client_(Client::connect(address)),
        states_(read(folder + "/states")),
        checkpoint_(read(folder + "/checkpoint")),
        from_(from),
        count_(count) {}

  void steps() {
    repeat("step", [&](auto& session) { same(session.step(any())); });
  }
  void drives() {
    const auto session = create();
    auto drive = session.drive();
    while (!over()) call("drive", [&] { same(drive.step(any())); });
  }
  void streams() {
    repeat("stream", [&](auto& session) {
      const std::int64_t to = from_ + count_ - 1;
      auto stream = session.stream({.from = from_, .to = to});
      std::int64_t next = from_;
      auto since = Time::now();
      while (const auto* batch = stream.next_batch()) {
        measure(since);
        for (int i = 0; i < batch->steps_size(); ++i) same(*batch, i, next++);
        since = Time::now();
      }
      if (next != to + 1) throw std::runtime_error("the stream ended early");
    });
  }
  void forks() {
    repeat("fork", [&](auto& session) {
      v1::ForkSessionRequest at;
      at.set_from_step(any());
      const auto fork = session.fork(at);
      const auto reply = fork.step(5);
      const auto simulation = make_simulation(server::read_scene(true, fork.scene())->scene);
      simulation->advance(5);
      std::string expected;
      append_state(*simulation, expected);
      if (bytes(reply.sample()) != expected) ++differing_;
    });
  }
  void diagnoses() {
    repeat("diagnose", [&](auto& session) {
      const auto reply = session.diagnose(any(), {"energy"});
      if (reply.invariants_size() != 1 || !(reply.invariants(0).drift() < 1e-9)) ++differing_;
    });
  }
  void summaries() {
    repeat("summarize", [&](auto& session) {
      v1::SummarizeRequest request;
      request.set_from(from_);
      request.set_to(any());
      for (const char* block : {"Q", "M"}) {
        auto* quantity = request.add_quantities();
        quantity->set_name(block);
        quantity->add_statistics(v1::STATISTIC_LAST);
      }
      const auto reply = session.summarize(request);
      std::string found;
      for (int i = 0; i < 2; ++i) found += reply.statistics(i).value().data();
      compare(found, request.to());
    });
  }
  /// A deleted session is there for no later call of its handle.
  void deletions() {
    while (!over()) {
      std::optional<Session> session;
      call("create", [&] { session.emplace(create()); });
      if (!session) continue;
      auto drive = session->drive();
      call("first", [&] { same(drive.step(any())); });
      call("delete", [&] { client_.remove(session->id()); });
      session.reset();
      try {
        drive.step(any());
        ++back_;
      } catch (const Error& error) {
        if (error.code() != grpc::StatusCode::NOT_FOUND) ++back_;
      }
    }
  }

  void run(double seconds) {
    end_ = Time::now() +
           std::chrono::duration_cast<Time::duration>(std::chrono::duration<double>(seconds));
    std::vector<std::jthread> threads;
    for (const auto kind : {&Run::steps, &Run::drives, &Run::streams, &Run::forks, &Run::diagnoses,
                            &Run::summaries, &Run::deletions})
      threads.emplace_back([this, kind] { (this->*kind)(); });
  }
  nlohmann::json report() const {
    return {{"calls", calls_},
            {"lost", lost_},
            {"differing", differing_.load()},
            {"back", back_.load()},
            {"pauses", pauses_}};
  }

 private:
  bool over() const { return Time::now() >= end_; }
  Session create() const { return client_.create(wire_scene(), "", checkpoint_); }

  template <class Work>
  void repeat(const char* kind, Work work) {
    const auto session = create();
    while (!over()) call(kind, [&] { work(session); });
  }
  template <class Work>
  void call(const char* kind, Work work) {
    const auto begin = Time::now();
    std::string fault;
    try {
      work();
    } catch (const std::exception& error) {
      fault = error.what();
    }
    if (std::string_view(kind) != "stream") measure(begin);
    const std::lock_guard lock(mutex_);
    ++calls_[kind];
    if (!fault.empty()) lost_.push_back(std::string(kind) + ": " + fault);
  }
  /// A call that takes so long has been repeated, or the machine is busy.
  void measure(Time::time_point since) {
    const double seconds = std::chrono::duration<double>(Time::now() - since).count();
    const std::lock_guard lock(mutex_);
    if (seconds > 0.02) pauses_.push_back(seconds);
  }

  std::int64_t any() {
    const std::lock_guard lock(mutex_);
    return from_ + static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(count_));
  }
  void compare(std::string_view found, std::int64_t step) {
    if (found != std::string_view(states_).substr(
                     static_cast<std::size_t>(step - from_) * state_bytes, state_bytes))
      ++differing_;
  }
  void same(const v1::StepResponse& reply) {
    compare(bytes(reply.sample()), reply.sample().step());
  }
  void same(const v1::StreamResponse& batch, int index, std::int64_t step) {
    std::string found;
    for (const auto& field : batch.fields()) {
      const std::size_t size =
          field.value().data().size() / static_cast<std::size_t>(batch.steps_size());
      found += field.value().data().substr(static_cast<std::size_t>(index) * size, size);
    }
    if (batch.steps(index) != step) ++differing_;
    compare(found, step);
  }
  static std::string bytes(const v1::Sample& sample) {
    std::string all;
    for (const auto& field : sample.fields()) all += field.value().data();
    return all;
  }

  const Client client_;
  const std::string states_, checkpoint_;
  const std::int64_t from_, count_;
  Time::time_point end_;
  std::atomic<std::int64_t> differing_ = 0, back_ = 0;
  std::mutex mutex_;
  std::mt19937_64 random_{17};                 // guarded by mutex_
  std::map<std::string, std::int64_t> calls_;  // guarded by mutex_
  std::vector<std::string> lost_;              // guarded by mutex_
  std::vector<double> pauses_;                 // guarded by mutex_
};

int main(const std::vector<std::string>& arguments) {
  const auto number = [&](std::size_t i) { return std::stoll(arguments.at(i)); };
  const std::string& mode = arguments.at(1);
  if (mode == "states") {
    write_states(arguments.at(2), number(3), number(4));
  } else if (mode == "checkpoint") {
    const auto session = Client::connect(arguments.at(2)).create(wire_scene());
    write(arguments.at(3) + "/checkpoint", session.checkpoint(number(4)).checkpoint());
  } else {
    Run run(arguments.at(2), arguments.at(3), number(4), number(5));
    run.run(std::stod(arguments.at(6)));
    std::cout << run.report() << '\n';
  }
  return 0;
}

}  // namespace
}  // namespace stiefel::client

int main(int count, char** arguments) {
  try {
    return stiefel::client::main({arguments, arguments + count});
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
