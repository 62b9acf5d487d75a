// A fault names the field of the request that its author wrote, in every call.
#include <cmath>
#include <limits>
#include <map>

#include "tests/server/harness.h"

namespace stiefel {
namespace {

using google::protobuf::RepeatedField;

const double nan = std::numeric_limits<double>::quiet_NaN();

class Paths : public testing::Test {
 protected:
  using Faults = std::map<std::string, std::string>;

  /// The fields of an INVALID_ARGUMENT's violations with their descriptions, one a line.
  static Faults faults_of(const grpc::Status& status) {
    EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT) << status.error_message();
    v1::Status details;
    EXPECT_TRUE(details.ParseFromString(status.error_details()));
    Faults faults;
    for (const auto& any : details.details()) {
      v1::BadRequest bad;
      if (any.type_url() != "type.googleapis.com/google.rpc.BadRequest") continue;
      EXPECT_TRUE(bad.ParseFromString(any.value()));
      for (const auto& violation : bad.field_violations())
        faults[violation.field()] += violation.description() + "\n";
    }
    return faults;
  }
  template <class Request, class Response>
  Faults ask(grpc::Status (test::Stub::*method)(grpc::ClientContext*, const Request&, Response*),
             const Request& request) {
    grpc::ClientContext context;
    Response response;
    return faults_of((*harness_.stub.*method)(&context, request, &response));
  }
  Faults create(const v1::Scene& scene) {
    v1::CreateSessionRequest request;
    request.set_session_id("new");
    *request.mutable_scene() = scene;
    return ask(&test::Stub::CreateSession, request);
  }
  Faults convert(const v1::ConvertRequest& request) {
    grpc::Status status;
    EXPECT_TRUE(harness_.convert(request, &status).empty());
    return faults_of(status);
  }
  Faults fork(const v1::ForkSessionRequest& request) {
    return ask(&test::Stub::ForkSession, request);
  }
  Faults measure(const v1::MeasureTradeoffRequest& request) {
    grpc::ClientContext context;
    const auto reader = harness_.stub->MeasureTradeoff(&context, request);
    v1::MeasureTradeoffResponse part;
    while (reader->Read(&part)) {
    }
    return faults_of(reader->Finish());
  }
  Faults diagnose(const std::function<void(v1::DiagnoseRequest&)>& change,
                  const std::string& id = "s") {
    v1::DiagnoseRequest request;
    request.set_session_id(id);
    change(request);
    return ask(&test::Stub::Diagnose, request);
  }
  static v1::Scene changed(const std::function<void(v1::Scene&)>& change) {
    v1::Scene scene = test::wire_scene();
    change(scene);
    return scene;
  }

  test::Harness harness_;
};

v1::Matrix matrix(const RowMatrix& values) {
  v1::Matrix out;
  server::to_proto(values, &out);
  return out;
}

void expect_field(const std::map<std::string, std::string>& faults, const std::string& field,
                  const std::string& description = "") {
  const auto found = faults.find(field);
  std::string all;
  for (const auto& [name, text] : faults) all += name + ": " + text + "\n";
  ASSERT_NE(found, faults.end()) << field << " is not among\n" << all;
  EXPECT_NE(found->second.find(description), std::string::npos) << all;
}

/// Faults of a scene, each with its path.
const std::vector<std::pair<std::string, std::function<void(v1::Scene&)>>>& wrong_scenes() {
  static const std::vector<std::pair<std::string, std::function<void(v1::Scene&)>>> all = {
      {"system", [](auto& s) { s.set_system("rigid_bodi"); }},
      {"inertia[1]", [](auto& s) { s.set_inertia(1, nan); }},
      {"step", [](auto& s) { s.clear_step(); }},
      {"epsilon", [](auto& s) { s.set_epsilon(1); }},
      {"parameter", [](auto& s) { s.set_parameter(1); }},
      {"initial.Q", [](auto& s) { (*s.mutable_initial())["Q"].set_values(0, 2); }},
      {"initial.M.values", [](auto& s) { (*s.mutable_initial())["M"].add_values(0); }},
      {"initial_tensors.M", [](auto& s) { (*s.mutable_initial_tensors())["M"]; }},
      {"initial_tensors.X.data_type", [](auto& s) { (*s.mutable_initial_tensors())["X"]; }},
      {"horizon", [](auto& s) { s.set_horizon(-1); }},
      {"tolerance", [](auto& s) { s.set_tolerance(1e-6), s.set_horizon(1); }},
  };
  return all;
}

TEST_F(Paths, OfCreateSession) {
  expect_field(ask(&test::Stub::CreateSession, v1::CreateSessionRequest()), "session_id", "empty");
  v1::CreateSessionRequest nothing;
  nothing.set_session_id("new");
  expect_field(ask(&test::Stub::CreateSession, nothing), "scene", "absent");
  for (const auto& [field, change] : wrong_scenes())
    expect_field(create(changed(change)), "scene." + field);
  expect_field(create(changed([](auto& s) { s.mutable_method()->set_order(1u << 31); })),
               "scene.method.order", "2147483648: is too large");
  expect_field(create(changed([](auto& s) { s.set_members(0); })), "scene.members", "0");
  expect_field(create(changed([](auto& s) {
                 s.clear_method();
                 s.set_tolerance(1e-15);
                 s.set_horizon(1e4);
               })),
               "scene.tolerance", "1e-15");
}

TEST_F(Paths, OfAMemberNamesTheMember) {
  v1::Scene scene = test::wire_scene();
  for (auto& [name, block] : *scene.mutable_initial()) {
    const RepeatedField<double> one = block.values();
    block.mutable_values()->Add(one.begin(), one.end());
    block.set_rows(2 * block.rows());
  }
  scene.set_members(2);
  (*scene.mutable_initial())["Q"].set_values(9, 2);
  expect_field(create(scene), "scene.initial.Q", "(member 1)");
}

TEST_F(Paths, OfANumberThatOverflows) {
  v1::Scene scene;
  scene.set_system("stiefel_costate");
  scene.mutable_method()->set_name("rk4");
  scene.set_step(0.01);
  for (int k = 0; k < 3; ++k) scene.add_inertia(1e-150);
  (*scene.mutable_initial())["Q"] = matrix(RowMatrix::Identity(1, 3));
  (*scene.mutable_initial())["P"] = matrix((RowMatrix(1, 3) << 0, 1e200, 0).finished());
  expect_field(create(scene), "scene.initial.P", "max |P| must be 1e-153 to 1e+153");
}

TEST_F(Paths, OfConvert) {
  v1::ConvertRequest request;
  request.set_to("velocity");
  expect_field(convert(request), "scene", "absent");
  for (const auto& [field, change] : wrong_scenes()) {
    *request.mutable_scene() = changed(change);
    expect_field(convert(request), "scene." + field);
  }
  *request.mutable_scene() = test::wire_scene();
  request.set_to("velocitty");
  expect_field(convert(request), "to", "did you mean velocity?");
  request.set_to("double_bracket");
  expect_field(convert(request), "to", "cannot be reached");
  request.set_to("parametric_rigid_body");
  request.set_parameter(nan);
  expect_field(convert(request), "parameter", "nan: must be finite");
  request.clear_parameter();
  request.set_to("symmetric_rigid_body");
  request.set_epsilon(0);
  expect_field(convert(request), "epsilon", "0: must be finite and not 0");
  request.clear_epsilon();
  *request.mutable_scene() = changed([](auto& s) { s.mutable_initial()->erase("Q"); });
  request.set_to("velocity");
  expect_field(convert(request), "scene.initial.Q", "absent");
  *request.mutable_scene() = changed([](auto& s) { s.set_members(2); });
  expect_field(convert(request), "scene.initial.M", "3 x 3");
}

TEST_F(Paths, OfForkSession) {
  harness_.create("s", test::wire_scene());
  v1::ForkSessionRequest request;
  request.set_session_id("new");
  request.set_from_session_id("a b");
  expect_field(fork(request), "from_session_id", "a b");
  request.set_from_session_id("s");
  const auto with = [&](const std::function<void(v1::ForkSessionRequest&)>& change) {
    v1::ForkSessionRequest changed = request;
    change(changed);
    return fork(changed);
  };
  expect_field(with([](auto& r) { r.set_session_id("a b"); }), "session_id", "a b");
  expect_field(with([](auto& r) { r.set_from_step(-1); }), "from_step", "-1");
  expect_field(with([](auto& r) { r.set_step(0); }), "step", "0");
  expect_field(with([](auto& r) { r.mutable_method()->set_name("rk5"); }), "method.name",
               "did you mean rk4?");
  expect_field(with([](auto& r) { r.mutable_method()->set_order(1u << 31); }), "method.order",
               "too large");
  expect_field(with([](auto& r) { r.set_system("stifel"); }), "system", "did you mean stiefel?");
  expect_field(with([](auto& r) { r.set_system("velocity"); }), "system", "velocity");
  expect_field(with([](auto& r) { r.set_system("double_bracket"); }), "system",
               "cannot be reached");
}

TEST_F(Paths, OfWhatAForkInherits) {
  harness_.create("huge", changed([](auto& s) {
                    s.set_step(1e-30);
                    for (double& x : *(*s.mutable_initial())["M"].mutable_values()) x *= 1e25;
                  }));
  v1::ForkSessionRequest request;
  request.set_session_id("new");
  request.set_from_session_id("huge");
  request.mutable_method()->set_name("rk4");
  request.mutable_method()->set_scalar("float");
  expect_field(fork(request), "from_session_id", "initial.M: ");

  harness_.create("momentum", changed([](auto& s) { s.mutable_initial()->erase("Q"); }));
  request.Clear();
  request.set_session_id("new");
  request.set_from_session_id("momentum");
  request.set_system("symmetric_rigid_body");
  expect_field(fork(request), "from_session_id", "initial.Q: absent");
}

TEST_F(Paths, OfMeasureTradeoff) {
  v1::MeasureTradeoffRequest request;
  expect_field(measure(request), "scene", "absent");
  for (const auto& [field, change] : wrong_scenes()) {
    // Its method is not looked at, nor what it was chosen for.
    if (field == "tolerance") continue;
    *request.mutable_scene() = changed(change);
    expect_field(measure(request), "scene." + field);
  }
  *request.mutable_scene() = test::wire_scene();
  request.mutable_scene()->set_members(5000);
  request.set_horizon(-1);
  request.set_budget(0);
  request.set_repeats(4'000'000'000);
  const auto faults = measure(request);
  expect_field(faults, "scene.members", "5000: must be at most 1024");
  expect_field(faults, "horizon", "-1");
  expect_field(faults, "budget", "0");
  expect_field(faults, "repeats", "4000000000: must be 1 to 100");
}

TEST_F(Paths, OfConnect) {
  const auto connect = [&](const std::function<void(v1::ConnectRequest&)>& change) {
    v1::ConnectRequest request;
    for (const double lambda : {1.0, 2.0, 3.0}) request.add_inertia(lambda);
    for (int k = 0; k < 2; ++k) {
      v1::FramePair& pair = *request.add_pairs();
      for (v1::Matrix* Q : {pair.mutable_q_0(), pair.mutable_q_t()})
        *Q = matrix(RowMatrix::Identity(2, 3));
    }
    request.set_time(1);
    change(request);
    grpc::Status status;
    EXPECT_TRUE(harness_.connect(request, &status).empty()) << "nothing before all is checked";
    return faults_of(status);
  };
  const auto last = [](auto& r) -> v1::FramePair& { return *r.mutable_pairs(1); };
  expect_field(connect([](auto& r) { r.clear_pairs(); }), "pairs", "0 pairs: must be 1 to 1024");
  expect_field(connect([](auto& r) {
                 while (r.pairs_size() < 1025) *r.add_pairs() = r.pairs(0);
               }),
               "pairs", "1025 pairs");
  expect_field(connect([&](auto& r) { last(r).clear_q_0(); }), "pairs[1].Q_0", "absent");
  expect_field(connect([&](auto& r) { last(r).mutable_q_t()->add_values(0); }),
               "pairs[1].Q_T.values", "7 values");
  expect_field(connect([&](auto& r) { last(r).mutable_q_0()->set_rows(0); }), "pairs[1].Q_0.rows",
               "0");
  expect_field(
      connect([&](auto& r) { *last(r).mutable_q_t() = matrix(RowMatrix::Identity(3, 3)); }),
      "pairs[1].Q_T", "3 x 3: must have the shape of Q_0, 2 x 3");
  expect_field(connect([](auto& r) { r.set_inertia(1, nan); }), "inertia[1]", "nan");
  expect_field(connect([](auto& r) { r.set_inertia(1, -4); }), "inertia", "-4");
  expect_field(connect([](auto& r) { r.add_inertia(1); }), "inertia", "4 numbers: must have 3");
  expect_field(connect([](auto& r) { r.set_time(-1e-9); }), "time", "-1e-09");
  expect_field(connect([](auto& r) { r.set_steps(1u << 31); }), "steps", "2147483648");
  expect_field(connect([](auto& r) { r.set_samples(1u << 31); }), "samples", "2147483648");
  expect_field(connect([](auto& r) { r.set_restarts(1u << 31); }), "restarts", "2147483648");
  const auto off = connect([&](auto& r) { last(r).mutable_q_0()->set_values(1, 3e-6); });
  expect_field(off, "pairs[1].Q_0", "3e-06: must have orthonormal rows to 1e-06");
  expect_field(connect([](auto& r) { r.set_metric(v1::METRIC_EUCLIDEAN); }), "inertia",
               "3 numbers: must be absent with METRIC_EUCLIDEAN");
  expect_field(connect([](auto& r) { r.set_metric(v1::METRIC_CANONICAL); }), "metric",
               "METRIC_CANONICAL: must be METRIC_LAMBDA or METRIC_EUCLIDEAN");
  expect_field(connect([](auto& r) { r.set_metric(static_cast<v1::Metric>(9)); }), "metric", "9");
}

TEST_F(Paths, OfDiagnose) {
  harness_.create("s", test::wire_scene());
  expect_field(diagnose([](auto& r) { r.set_to(-1); }), "to", "-1");
  expect_field(diagnose([](auto& r) { r.set_max_invariants(8193); }), "max_invariants", "8193");
  expect_field(diagnose([](auto& r) {
                 for (int k = 0; k < 10'001; ++k) r.add_forms();
               }),
               "forms", "10001: must be at most 10000");
  expect_field(diagnose([](auto& r) { r.add_invariants("enrgy"); }), "invariants[0]",
               "did you mean energy?");
  expect_field(diagnose([](auto& r) { r.mutable_symplectic_test()->set_pairs(1001); }),
               "symplectic_test.pairs", "1001");
  expect_field(diagnose([](auto& r) { r.add_dirac_brackets(); }), "dirac_brackets[0]",
               "rigid_body");
  const auto form = [&](const std::string& name, const RowMatrix& M) {
    return diagnose([&](v1::DiagnoseRequest& r) {
      auto* omega = r.add_forms();
      omega->set_form(name);
      for (auto* vector : {omega->mutable_first(), omega->mutable_second()}) {
        (*vector)["Q"] = matrix(RowMatrix::Zero(3, 3));
        (*vector)["M"] = matrix(M);
      }
      (*omega->mutable_second())["m"] = matrix(M);
    });
  };
  expect_field(form("omgea", RowMatrix::Zero(3, 3)), "forms[0].form", "did you mean omega?");
  expect_field(form("omega", RowMatrix::Zero(2, 3)), "forms[0].first.M", "2 x 3: must be given");
  expect_field(form("omega", RowMatrix::Zero(3, 3)), "forms[0].second.m", "did you mean M?");
  RowMatrix barely = RowMatrix::Zero(3, 3);
  barely << 0, 1, 0, -1 + 1e-7, 0, 0, 0, 0, 0;
  const auto off = form("omega", barely);
  expect_field(off, "forms[0].first", "e-08 at norm 1.41");
  EXPECT_EQ(off.at("forms[0].first").find("0.000000"), std::string::npos);
}

TEST_F(Paths, OfBracketsAndEnsembles) {
  v1::ConvertRequest to;
  *to.mutable_scene() = test::wire_scene();
  to.set_to("symmetric_rigid_body");
  to.set_view(v1::SCENE_VIEW_FULL);
  harness_.create("pair", harness_.convert(to).at(0).scene());
  const auto change = [](v1::DiagnoseRequest& r) {
    auto* bracket = r.add_dirac_brackets();
    for (auto* functions : {bracket->mutable_first(), bracket->mutable_second()})
      for (int k = 0; k < 2; ++k) {
        auto* function = functions->Add();
        *function->mutable_a() = matrix(RowMatrix::Zero(3, 3));
        *function->mutable_b() = matrix(RowMatrix::Zero(3, 3));
      }
    *bracket->mutable_second(1)->mutable_b() = matrix(RowMatrix::Zero(3, 2));
  };
  expect_field(diagnose(change, "pair"), "dirac_brackets[0].second[1].B", "3 x 2");
  harness_.create("ensemble", changed([](auto& s) { s.set_members(1); }));
  const char* rule = "1 members: the scene must have no `members`: two-forms and brackets are";
  expect_field(diagnose([](auto& r) { r.add_forms()->set_form("omega"); }, "ensemble"), "forms[0]",
               rule);
  expect_field(diagnose([](auto& r) { r.mutable_symplectic_test(); }, "ensemble"),
               "symplectic_test", rule);
}

TEST_F(Paths, OfWhatIsAskedOfASession) {
  harness_.create("s", test::wire_scene());
  v1::StepRequest step;
  step.set_session_id("s");
  step.add_fields("Omga");
  expect_field(ask(&test::Stub::Step, step), "fields[0]", "did you mean Omega?");
  v1::StreamRequest range;
  range.set_session_id("s");
  range.set_from(3);
  range.set_to(2);
  grpc::ClientContext context;
  const auto reader = harness_.stub->Stream(&context, range);
  v1::StreamResponse message;
  EXPECT_FALSE(reader->Read(&message));
  expect_field(faults_of(reader->Finish()), "to", "2");
  v1::GetSessionRequest get;
  expect_field(ask(&test::Stub::GetSession, get), "session_id", "empty");
  v1::DeleteSessionRequest erase;
  expect_field(ask(&test::Stub::DeleteSession, erase), "session_id", "empty");
  v1::ListSessionsRequest list;
  for (const char* token : {"a b", "s", "0123456773", "00"}) {
    list.set_page_token(token);
    expect_field(ask(&test::Stub::ListSessions, list), "page_token", token);
  }
}

}  // namespace
}  // namespace stiefel
