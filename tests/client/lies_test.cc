// Whatever a server answers, a call ends with an answer or with CorruptReply.
#include <google/protobuf/reflection.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/server.h"
#include "stiefel/client/client.h"
#include "tests/client/wire_scenes.h"

namespace stiefel::client {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using Change = std::function<void(Message&)>;
constexpr int deepest = 4;  // levels of messages within messages in which fields are changed

/// A field of a message, or an element of a list of messages.
struct Place {
  const FieldDescriptor* field;
  int index = -1;
};
using Path = std::vector<Place>;

/// Returns the message at the path; null if the root has fewer elements in a list than the message
/// from which the path was made.
Message* at(Message& root, const Path& path) {
  Message* message = &root;
  for (const Place& place : path) {
    const auto* reflection = message->GetReflection();
    if (place.index >= 0 && reflection->FieldSize(*message, place.field) <= place.index)
      return nullptr;
    message = place.index < 0
                  ? reflection->MutableMessage(message, place.field)
                  : reflection->MutableRepeatedMessage(message, place.field, place.index);
  }
  return message;
}

/// Adds the changes of one field, which is in the message at `path`.
void add_changes(const Path& path, const FieldDescriptor* field,
                 std::map<std::string, Change>& changes) {
  std::string name;
  for (const Place& place : path) name += place.field->name() + ".";
  name += field->name();
  const auto add = [&](const char* what, auto change) {
    changes[name + what] = [=](Message& root) {
      if (Message* message = at(root, path)) change(*message, message->GetReflection());
    };
  };
  add(" dropped", [=](Message& m, auto* r) { r->ClearField(&m, field); });
  if (field->is_repeated())
    return add(" shorter", [=](Message& m, auto* r) {
      if (r->FieldSize(m, field) > 0) r->RemoveLast(&m, field);
    });
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_STRING:
      for (const std::size_t bytes : {1, 8})
        add(bytes == 1 ? " a byte shorter" : " 8 bytes shorter", [=](Message& m, auto* r) {
          const std::string text = r->GetString(m, field);
          r->SetString(&m, field, text.substr(0, text.size() - std::min(text.size(), bytes)));
        });
      return add(" longer", [=](Message& m, auto* r) {
        r->SetString(&m, field, r->GetString(m, field) + "12345678");
      });
    case FieldDescriptor::CPPTYPE_ENUM:
      for (int value = 0; value < 6; ++value)
        add((" " + std::to_string(value)).c_str(),
            [=](Message& m, auto* r) { r->SetEnumValue(&m, field, value); });
      return add(" 99", [=](Message& m, auto* r) { r->SetEnumValue(&m, field, 99); });
    case FieldDescriptor::CPPTYPE_UINT32:
      return add(" greater",
                 [=](Message& m, auto* r) { r->SetUInt32(&m, field, r->GetUInt32(m, field) + 1); });
    case FieldDescriptor::CPPTYPE_UINT64:
      return add(" greater",
                 [=](Message& m, auto* r) { r->SetUInt64(&m, field, r->GetUInt64(m, field) + 1); });
    case FieldDescriptor::CPPTYPE_INT64:
      add(" greater",
          [=](Message& m, auto* r) { r->SetInt64(&m, field, r->GetInt64(m, field) + 1); });
      return add(" negative", [=](Message& m, auto* r) { r->SetInt64(&m, field, -7); });
    default:
      return;
  }
}

void add_changes(const Message& message, const Path& path, std::map<std::string, Change>& changes) {
  std::vector<const FieldDescriptor*> present;
  message.GetReflection()->ListFields(message, &present);
  for (const FieldDescriptor* field : present) {
    add_changes(path, field, changes);
    if (field->message_type() == nullptr || field->is_map() || path.size() == deepest) continue;
    const auto* reflection = message.GetReflection();
    const auto descend = [&](const Message& inner, int index) {
      Path inside = path;
      inside.push_back({field, index});
      add_changes(inner, inside, changes);
    };
    if (!field->is_repeated()) {
      descend(reflection->GetMessage(message, field), -1);
      continue;
    }
    for (const int index : {0, reflection->FieldSize(message, field) - 1})
      descend(reflection->GetRepeatedMessage(message, field, index), index);
  }
}

/// Passes calls on to a right server, but for deletions. Changes reply number `index`, or leaves it
/// out if there is no change, and keeps what the right server has said.
class Liar : public v1::SimulationService::Service {
 public:
  explicit Liar(const std::shared_ptr<grpc::Channel>& right)
      : right_(v1::SimulationService::NewStub(right)) {}

  void tell_the_truth() { lie(-1, nullptr); }
  void lie(int at, Change with) {
    const std::lock_guard lock(mutex_);
    index_ = at;
    change_ = std::move(with);
    told_.clear();
    ++run_;
  }
  std::vector<std::unique_ptr<Message>> told() {
    const std::lock_guard lock(mutex_);
    return std::exchange(told_, {});
  }

#define UNARY(Name)                                                                           \
  grpc::Status Name(grpc::ServerContext*, const v1::Name##Request* request,                   \
                    v1::Name##Response* reply) override {                                     \
    if (std::is_same_v<v1::Name##Request, v1::DeleteSessionRequest>) return grpc::Status::OK; \
    grpc::ClientContext context;                                                              \
    const int run = run_;                                                                     \
    const grpc::Status status = right_->Name(&context, *request, reply);                      \
    if (status.ok()) lies(*reply, run);                                                       \
    return status;                                                                            \
  }
#define STREAM(Name)                                                           \
  grpc::Status Name(grpc::ServerContext*, const v1::Name##Request* request,    \
                    grpc::ServerWriter<v1::Name##Response>* writer) override { \
    grpc::ClientContext context;                                               \
    const int run = run_;                                                      \
    const auto reader = right_->Name(&context, *request);                      \
    for (v1::Name##Response reply; reader->Read(&reply);)                      \
      if (lies(reply, run)) writer->Write(reply);                              \
    return reader->Finish();                                                   \
  }
#define DUPLEX(Name)
#include "stiefel/v1/rpcs.inc"
#undef UNARY
#undef STREAM
#undef DUPLEX

  grpc::Status Drive(
      grpc::ServerContext*,
      grpc::ServerReaderWriter<v1::DriveResponse, v1::DriveRequest>* stream) override {
    grpc::ClientContext context;
    const int run = run_;
    const auto right = right_->Drive(&context);
    v1::DriveRequest request;
    v1::DriveResponse reply;
    while (stream->Read(&request) && right->Write(request) && right->Read(&reply)) {
      lies(reply, run);
      stream->Write(reply);
    }
    context.TryCancel();
    return grpc::Status::OK;
  }

 private:
  /// Returns whether the reply is to be sent. The call of an earlier lie, which the client has
  /// left, may still be served.
  template <class Reply>
  bool lies(Reply& reply, int run) {
    const std::lock_guard lock(mutex_);
    if (run != run_) return true;
    const bool now = std::cmp_equal(told_.size(), index_);
    told_.push_back(std::make_unique<Reply>(reply));
    if (now && change_) change_(reply);
    return !now || change_;
  }

  std::mutex mutex_;
  std::atomic<int> run_ = 0;
  int index_ = -1;
  Change change_;
  std::vector<std::unique_ptr<Message>> told_;

  std::unique_ptr<v1::SimulationService::Stub> right_;
};

class LiesTest : public testing::Test {
 protected:
  LiesTest() : right_({.threads = 1, .log_level = "off"}), liar_(right_.in_process_channel()) {
    grpc::ServerBuilder builder;
    builder.RegisterService(&liar_);
    server_ = builder.BuildAndStart();
    client_.emplace(server_->InProcessChannel({}));
    session_.emplace(client_->create(tumbling(), "lied-about"));
    session_->keep();
  }

  /// Makes the call with every lie about each of its first and last replies.
  void lie_about(const std::function<void()>& call) {
    liar_.tell_the_truth();
    call();
    const auto told = liar_.told();
    ASSERT_FALSE(told.empty());
    int noticed = 0;
    for (const std::size_t index : {std::size_t{0}, told.size() / 2, told.size() - 1}) {
      std::map<std::string, Change> changes = {{"empty", [](Message& m) { m.Clear(); }}};
      if (told.size() > 1) changes["absent"] = nullptr;
      add_changes(*told[index], {}, changes);
      for (const auto& [name, change] : changes) {
        liar_.lie(static_cast<int>(index), change);
        try {
          call();
        } catch (const CorruptReply&) {
          ++noticed;
        } catch (const std::exception& other) {
          ADD_FAILURE() << index << ": " << name << ": " << other.what();
        }
      }
    }
    EXPECT_GT(noticed, 4);
  }

  server::Server right_;
  Liar liar_;
  std::unique_ptr<grpc::Server> server_;
  std::optional<Client> client_;
  std::optional<Session> session_;
};

TEST_F(LiesTest, OfCallsAboutSessions) {
  lie_about([&] { client_->describe(); });
  lie_about([&] { client_->create(tumbling(), "lied-about").keep(); });
  lie_about([&] { client_->attach("lied-about").scene(); });
  lie_about([&] { session_->refresh(); });
}

TEST_F(LiesTest, OfStates) {
  lie_about([&] { field(session_->step(5, {"Q", "M"}).sample(), "Q"); });
  lie_about([&] { session_->checkpoint(7); });
  lie_about([&] {
    auto drive = session_->drive();
    field(drive.step(3, {"Q"}).sample(), "Q");
  });
  lie_about([&] {
    double sum = 0;
    auto stream = session_->stream({.to = 20, .every = 3});
    for (const SampleView sample : stream)
      for (int i = 0; i < sample.field_count(); ++i)
        for (std::size_t k = 0; k < sample.field(i).size(); ++k) sum += sample.field(i)[k];
    EXPECT_TRUE(stream.run_status());
  });
}

TEST_F(LiesTest, OfWhatIsComputed) {
  v1::DiagnoseRequest diagnosis;
  diagnosis.set_to(5);
  diagnosis.set_estimate_error(v1::ERROR_ESTIMATION_ALWAYS);
  lie_about([&] { session_->diagnose(diagnosis); });
  for (const char* to : {"velocity", "symmetric_rigid_body"}) {
    v1::ConvertRequest conversion;
    *conversion.mutable_scene() = tumbling();
    conversion.set_to(to);
    lie_about([&] { client_->convert(conversion); });
  }
  v1::ConnectRequest pair;
  for (const double lambda : {1, 2, 3}) pair.add_inertia(lambda);
  pair.set_time(1);
  pair.set_samples(3);
  for (auto* frame : {pair.add_pairs()->mutable_q_0(), pair.mutable_pairs(0)->mutable_q_t()}) {
    frame->set_rows(1);
    frame->set_cols(3);
    for (int i = 0; i < 3; ++i) frame->add_values(0);
  }
  pair.mutable_pairs(0)->mutable_q_0()->set_values(0, 1);
  pair.mutable_pairs(0)->mutable_q_t()->set_values(1, 1);
  lie_about([&] { client_->geodesics(pair); });
  v1::SummarizeRequest summary;
  summary.set_to(300);
  auto& quantity = *summary.add_quantities();
  quantity.set_name("energy");
  quantity.add_statistics(v1::STATISTIC_DRIFT);
  auto& event = *summary.add_events();
  event.set_field("angular_velocity");
  for (const double coefficient : {1, 0, 0}) event.add_coefficients(coefficient);
  summary.add_times(0.5);
  lie_about([&] { EXPECT_TRUE(session_->summarize(summary).has_run_status()); });
  v1::LinearizeRequest tangent;
  tangent.set_to(20);
  tangent.set_every(10);
  lie_about([&] { EXPECT_TRUE(session_->linearize(tangent).has_run_status()); });
  v1::LyapunovSpectrumRequest growth;
  growth.set_to(40);
  growth.set_every(20);
  growth.set_interval(1);
  lie_about([&] { EXPECT_TRUE(session_->lyapunov(growth).has_run_status()); });
}

}  // namespace
}  // namespace stiefel::client
