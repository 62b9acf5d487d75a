// Every malformed request gets its code, the path of the field and the rule, and the server lives.
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "server/convert/errors.h"
#include "tests/server/harness.h"

namespace stiefel {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();
const double infinity = std::numeric_limits<double>::infinity();

class Errors : public testing::Test {
 protected:
  Errors() { harness_.create("s", test::wire_scene()); }

  grpc::Status create(const std::function<void(v1::CreateSessionRequest&)>& change) {
    v1::CreateSessionRequest request;
    request.set_session_id("new");
    *request.mutable_scene() = test::wire_scene();
    change(request);
    grpc::ClientContext context;
    v1::CreateSessionResponse response;
    return harness_.stub->CreateSession(&context, request, &response);
  }
  grpc::Status create_scene(const std::function<void(v1::Scene&)>& change) {
    return create([&](v1::CreateSessionRequest& request) { change(*request.mutable_scene()); });
  }
  grpc::Status step(const std::function<void(v1::StepRequest&)>& change) {
    v1::StepRequest request;
    request.set_session_id("s");
    change(request);
    grpc::ClientContext context;
    v1::StepResponse response;
    return harness_.stub->Step(&context, request, &response);
  }
  grpc::Status stream(std::int64_t from, std::int64_t to, std::int64_t every) {
    v1::StreamRequest request;
    request.set_session_id("s");
    request.set_from(from);
    request.set_to(to);
    request.set_every(every);
    grpc::ClientContext context;
    const auto reader = harness_.stub->Stream(&context, request);
    v1::StreamResponse message;
    EXPECT_FALSE(reader->Read(&message));
    return reader->Finish();
  }
  ~Errors() override {
    EXPECT_EQ(harness_.step("s", 10).sample().step(), 10) << "the server lives";
  }

  test::Harness harness_{{.max_sessions = 2}};
};

/// INVALID_ARGUMENT with a violation of the field, in the details and in the message.
void expect_invalid(const grpc::Status& status, const std::string& field) {
  EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT) << field << ": " << status.error_message();
  EXPECT_NE(status.error_message().find(field + ": "), std::string::npos) << status.error_message();
  v1::Status details;
  ASSERT_TRUE(details.ParseFromString(status.error_details())) << field;
  ASSERT_EQ(details.details_size(), 1) << field;
  EXPECT_EQ(details.details(0).type_url(), "type.googleapis.com/google.rpc.BadRequest");
  v1::BadRequest bad;
  ASSERT_TRUE(bad.ParseFromString(details.details(0).value()));
  const bool named = std::ranges::any_of(bad.field_violations(), [&](const auto& violation) {
    return violation.field() == field && !violation.description().empty();
  });
  EXPECT_TRUE(named) << field << " in " << bad.ShortDebugString();
}

void expect_reason(const grpc::Status& status, grpc::StatusCode code, const std::string& reason) {
  EXPECT_EQ(status.error_code(), code) << status.error_message();
  v1::Status details;
  ASSERT_TRUE(details.ParseFromString(status.error_details()));
  ASSERT_GE(details.details_size(), 1);
  EXPECT_EQ(details.details(0).type_url(), "type.googleapis.com/google.rpc.ErrorInfo");
  v1::ErrorInfo info;
  ASSERT_TRUE(info.ParseFromString(details.details(0).value()));
  EXPECT_EQ(info.reason(), reason);
  EXPECT_EQ(info.domain(), "stiefel");
}

TEST_F(Errors, OfScenes) {
  using Change = std::function<void(v1::Scene&)>;
  const auto Q = [](v1::Scene& scene) -> v1::Matrix& { return (*scene.mutable_initial())["Q"]; };
  const auto M = [](v1::Scene& scene) -> v1::Matrix& { return (*scene.mutable_initial())["M"]; };
  const std::pair<const char*, Change> table[] = {
      {"system", [](auto& s) { s.clear_system(); }},
      {"system", [](auto& s) { s.set_system("rigid_boby"); }},
      {"method.name", [](auto& s) { s.mutable_method()->set_name("euler"); }},
      {"method.order", [](auto& s) { s.mutable_method()->set_order(3); }},
      {"method.order", [](auto& s) { s.mutable_method()->set_order(4'000'000'000); }},
      {"method.substeps", [](auto& s) { s.mutable_method()->set_substeps(0); }},
      {"method.substeps", [](auto& s) { s.mutable_method()->set_substeps(4'000'000'000); }},
      {"method.arithmetic", [](auto& s) { s.mutable_method()->set_arithmetic("exact"); }},
      {"method", [](auto& s) { s.set_system("moser_veselov"); }},
      {"step", [](auto& s) { s.clear_step(); }},
      {"step", [](auto& s) { s.set_step(0); }},
      {"step", [](auto& s) { s.set_step(nan); }},
      {"step", [](auto& s) { s.set_step(infinity); }},
      {"inertia", [](auto& s) { s.clear_inertia(); }},
      {"inertia[0]", [](auto& s) { s.set_inertia(0, nan); }},
      {"inertia", [](auto& s) { s.set_inertia(0, -2); }},
      {"initial.Q.values", [&](auto& s) { Q(s).add_values(1); }},
      {"initial.Q.values", [&](auto& s) { Q(s).clear_values(); }},
      {"initial.Q.rows", [&](auto& s) { Q(s).set_rows(1'000'000'000); }},
      {"initial.Q.cols", [&](auto& s) { Q(s).set_cols(1'000'000'000); }},
      {"initial.Q.rows", [&](auto& s) { Q(s).set_rows(0); }},
      {"initial.Q", [&](auto& s) { Q(s).set_values(0, 1.1); }},
      {"initial.Q[1,0]", [&](auto& s) { Q(s).set_values(3, nan); }},
      {"initial.M", [&](auto& s) { M(s).set_values(1, 50); }},
      {"initial.M[0,1]", [&](auto& s) { M(s).set_values(1, infinity); }},
      {"initial.M", [](auto& s) { s.mutable_initial()->erase("M"); }},
      {"initial.M", [&](auto& s) { M(s) = test::wire_scene({.dimension = 5}).initial().at("M"); }},
      {"initial.X", [&](auto& s) { (*s.mutable_initial())["X"] = Q(s); }},
      {"body", [](auto& s) { s.mutable_body()->add_moments(1); }},
  };
  for (const auto& [field, change] : table) {
    const auto status = create_scene(change);
    EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT) << field;
    // A body's complaint may stand at any of the fields that contradict each other.
    if (std::string(field) != "body") expect_invalid(status, std::string("scene.") + field);
  }
}

TEST_F(Errors, AllAtOnce) {
  const auto status = create_scene([](v1::Scene& scene) {
    scene.set_step(0);
    scene.mutable_method()->set_name("euler");
  });
  expect_invalid(status, "scene.step");
  expect_invalid(status, "scene.method.name");
}

TEST_F(Errors, AFloodOfViolationsFitsInTheTrailers) {
  constexpr std::size_t blocks = 50;  // each without rows and without columns
  const auto status = create_scene([](v1::Scene& scene) {
    scene.clear_initial();
    for (std::size_t i = 0; i < blocks; ++i)
      (*scene.mutable_initial())[std::string(300, 'x') + std::to_string(i)];
  });
  EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT);
  const std::string& message = status.error_message();
  EXPECT_LT(message.size() + status.error_details().size(), 7000u);
  const std::size_t end = message.rfind("; and ");
  ASSERT_NE(end, std::string::npos) << message;
  const auto told = 1 + std::ranges::count(message.substr(0, end), ';');
  EXPECT_EQ(static_cast<std::size_t>(told) + std::stoul(message.substr(end + 6)), 2 * blocks);
}

TEST_F(Errors, MoreBlocksThanAnySystemHas) {
  const auto status = create_scene([](v1::Scene& scene) {
    for (int i = 0; i < 100; ++i) (*scene.mutable_initial())[std::to_string(i) + "x"];
  });
  expect_invalid(status, "scene.initial");
}

TEST_F(Errors, OfSessions) {
  for (const std::string& id :
       {std::string(), std::string(129, 'x'), std::string("a b"), std::string("ä")}) {
    expect_invalid(create([&](auto& request) { request.set_session_id(id); }), "session_id");
  }
  expect_invalid(create([](auto& request) { request.clear_scene(); }), "scene");
  expect_reason(create([](auto& request) {
                  request.set_session_id("s");
                  request.mutable_scene()->set_step(0.5);
                }),
                grpc::ALREADY_EXISTS, "SESSION_HAS_OTHER_SCENE");
  EXPECT_TRUE(create([](auto&) {}).ok());
  expect_reason(create([](auto& request) { request.set_session_id("third"); }),
                grpc::RESOURCE_EXHAUSTED, "TOO_MANY_SESSIONS");
}

TEST_F(Errors, TooManySessionsSaysWhichLimitAndWhenToRetry) {
  harness_.create("second", test::wire_scene());
  const auto status = create([](auto& request) { request.set_session_id("third"); });
  v1::Status details;
  ASSERT_TRUE(details.ParseFromString(status.error_details()));
  ASSERT_EQ(details.details_size(), 3);
  EXPECT_EQ(details.details(1).type_url(), "type.googleapis.com/google.rpc.QuotaFailure");
  v1::QuotaFailure quota;
  ASSERT_TRUE(quota.ParseFromString(details.details(1).value()));
  ASSERT_EQ(quota.violations_size(), 1);
  EXPECT_EQ(quota.violations(0).subject(), "sessions");
  EXPECT_EQ(quota.violations(0).description(), "at most 2");
  EXPECT_EQ(details.details(2).type_url(), "type.googleapis.com/google.rpc.RetryInfo");
  v1::RetryInfo retry;
  ASSERT_TRUE(retry.ParseFromString(details.details(2).value()));
  EXPECT_EQ(retry.retry_delay().seconds(), 1);
}

TEST(ErrorsOfResources, SayWhichQuotaAndWhenToRetry) {
  const auto expect = [](const grpc::Status& status, const char* reason, const char* subject) {
    expect_reason(status, grpc::RESOURCE_EXHAUSTED, reason);
    v1::Status details;
    ASSERT_TRUE(details.ParseFromString(status.error_details()));
    ASSERT_EQ(details.details_size(), 3) << reason;
    EXPECT_EQ(details.details(1).type_url(), "type.googleapis.com/google.rpc.QuotaFailure");
    v1::QuotaFailure quota;
    ASSERT_TRUE(quota.ParseFromString(details.details(1).value()));
    ASSERT_EQ(quota.violations_size(), 1);
    EXPECT_EQ(quota.violations(0).subject(), subject);
    EXPECT_EQ(server::errors::retry_delay(status), std::chrono::seconds(1)) << reason;
  };
  using Fault = server::WriteFault;
  expect(server::errors::out_of_memory(), "OUT_OF_MEMORY", "memory");
  expect(server::errors::not_written(Fault{Fault::Kind::full, "no space"}), "STORE_FULL", "store");
  expect(server::errors::not_written(Fault{Fault::Kind::out_of_memory, ""}), "OUT_OF_MEMORY",
         "memory");
}

TEST_F(Errors, OfRouting) {
  const auto routed = [&](const std::vector<std::string>& by) {
    v1::StepRequest request;
    request.set_session_id("s");
    grpc::ClientContext context;
    for (const std::string& name : by) context.AddMetadata("stiefel-session", name);
    v1::StepResponse response;
    return harness_.stub->Step(&context, request, &response);
  };
  EXPECT_TRUE(routed({}).ok());
  EXPECT_TRUE(routed({"s"}).ok());
  EXPECT_TRUE(routed({"s", "s"}).ok());
  for (const std::vector<std::string>& by :
       {std::vector<std::string>{"t"}, {"s", "t"}, {"t", "s"}, {"s", ""}})
    expect_invalid(routed(by), "session_id");
}

TEST_F(Errors, OfSteps) {
  expect_reason(step([](auto& r) { r.set_session_id("nobody"); }), grpc::NOT_FOUND,
                "SESSION_NOT_FOUND");
  expect_invalid(step([](auto& r) { r.set_session_id(""); }), "session_id");
  expect_invalid(step([](auto& r) { r.set_to(-1); }), "to");
  expect_invalid(step([](auto& r) { r.set_to((std::int64_t{1} << 53) + 1); }), "to");
  const auto with_fields = [&](const std::vector<std::string>& names) {
    return step([&](auto& r) { r.mutable_fields()->Assign(names.begin(), names.end()); });
  };
  expect_invalid(with_fields({"Q", "P"}), "fields[1]");
  expect_invalid(with_fields({"Q", "Q"}), "fields[1]");
}

TEST_F(Errors, OfStreams) {
  expect_invalid(stream(-1, 5, 1), "from");
  expect_invalid(stream(5, 4, 1), "to");
  expect_invalid(stream(0, std::numeric_limits<std::int64_t>::max(), 1), "to");
  expect_invalid(stream(0, 5, -1), "every");
}

TEST_F(Errors, OfDiagnose) {
  v1::DiagnoseRequest request;
  request.set_session_id("s");
  request.add_invariants("energy");
  request.add_invariants("entropy");
  grpc::ClientContext context;
  v1::DiagnoseResponse response;
  expect_invalid(harness_.stub->Diagnose(&context, request, &response), "invariants[1]");
}

TEST_F(Errors, OfCheckpoints) {
  std::string checkpoint = harness_.step("s", 100, true).checkpoint();
  const auto with = [&](const std::string& bytes) {
    return create([&](auto& request) { request.set_checkpoint(bytes); });
  };
  std::mt19937 random(2);
  const std::size_t begin = 7, end = 16;  // the format's version and the name of the key
  for (int i = 0; i < 200; ++i) {
    std::string damaged = checkpoint;
    const std::size_t at = random() % damaged.size();
    damaged[at] ^= 0x40;
    if (begin <= at && at < end)
      EXPECT_TRUE(with(damaged).ok()) << "another server's is ignored";
    else
      expect_invalid(with(damaged), "checkpoint");
  }
  expect_invalid(with("x"), "checkpoint");
  expect_invalid(create([&](auto& request) {
                   request.set_checkpoint(checkpoint);
                   *request.mutable_scene() = test::wire_scene({.dimension = 5});
                 }),
                 "checkpoint");
  EXPECT_TRUE(with(checkpoint).ok());
}

TEST_F(Errors, DriveGoesOn) {
  grpc::ClientContext context;
  const auto drive = harness_.stub->Drive(&context);
  const auto ask = [&](const std::string& id, std::int64_t to, const std::string& field = "") {
    v1::DriveRequest request;
    request.set_session_id(id);
    request.set_to(to);
    if (!field.empty()) request.add_fields(field);
    v1::DriveResponse response;
    EXPECT_TRUE(drive->Write(request) && drive->Read(&response));
    return response;
  };
  const v1::Status unknown = ask("nobody", 1).error();
  expect_reason({static_cast<grpc::StatusCode>(unknown.code()), unknown.message(),
                 unknown.SerializeAsString()},
                grpc::NOT_FOUND, "SESSION_NOT_FOUND");
  EXPECT_EQ(ask("s", -1).error().code(), grpc::INVALID_ARGUMENT);
  EXPECT_EQ(ask("", 5).step().sample().step(), 5);
  EXPECT_EQ(ask("", 5).step().sample().fields_size(), 2);
  EXPECT_EQ(ask("other", 5).error().code(), grpc::INVALID_ARGUMENT);
  EXPECT_EQ(ask("", 5, "P").error().code(), grpc::INVALID_ARGUMENT);
  EXPECT_EQ(ask("s", 6, "M").step().sample().fields(0).name(), "M");
  EXPECT_EQ(ask("", 7).step().sample().fields_size(), 1) << "the fields of the request before";
  drive->WritesDone();
  EXPECT_TRUE(drive->Finish().ok());
}

}  // namespace
}  // namespace stiefel
